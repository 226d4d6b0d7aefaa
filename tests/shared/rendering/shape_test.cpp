// What transitions do to the shape of bodies that turn and deform.

#include <catch2/catch.hpp>
#include <cmath>

#include "shared/rendering/renderer.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::shape_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 34 * kMillisecond_ns;
constexpr double kPeriod_s = 34e-3, kStiffness_N_per_m = 500.0, kRadius_m = 0.01;

/// Where a sphere and how fast it moves at a time.
using Path = std::function<Eigen::Vector3d(double)>;

double seconds(std::uint64_t time_ns) {
  return static_cast<double>(time_ns) * 1e-9;
}

/// Spheres on paths, shown every period.
struct MovingBody {
  std::vector<Path> paths;
  PublishedScene scene;
  std::unique_ptr<Renderer> renderer;
  std::uint64_t now_ns = 0;

  MovingBody(display::Transition transition, std::vector<Path> spheres)
      : paths(std::move(spheres)),
        scene(plain_scene(static_cast<float>(kStiffness_N_per_m), static_cast<float>(kRadius_m)),
              std::vector<float>(paths.size(), static_cast<float>(kRadius_m)), kPeriod_ns),
        renderer(make_renderer(transition)) {}

  void show() {
    std::vector<Eigen::Vector3d> places_m, velocities_m_s;
    const double t = seconds(now_ns), moment_s = 1e-6;
    for (const Path& path : paths) {
      places_m.push_back(path(t));
      velocities_m_s.push_back((path(t + moment_s) - path(t - moment_s)) / (2.0 * moment_s));
    }
    scene.show(places_m, velocities_m_s, now_ns);
  }

  /// Six snapshots, ticks between, and then so long after the last one.
  void run(std::uint64_t after_ns) {
    for (int n = 0; n < 6; ++n) {
      if (n > 0) now_ns += kPeriod_ns;
      show();
      (void)seen_m({1.0, 1.0, 1.0});
    }
    now_ns += after_ns;
  }

  /// Where a tool at tool_m feels the one sphere that it touches.
  [[nodiscard]] Eigen::Vector3d seen_m(const Eigen::Vector3d& tool_m) {
    const ToolForce force = renderer->render(scene.view(), {.position_m = tool_m}, now_ns).force;
    const double push_N = force.force_N.norm();
    return tool_m - (2.0 * kRadius_m - push_N / kStiffness_N_per_m) * force.force_N / push_N;
  }
};

constexpr double kRing_m = 0.05, kTurn_rad = 0.5;  // a period

/// Six spheres on a ring that turns.
std::vector<Path> turning_ring() {
  std::vector<Path> paths;
  for (int i = 0; i < 6; ++i)
    paths.push_back([i](double t) {
      const double angle = i * 1.0471975512 + kTurn_rad * t / kPeriod_s;
      return Eigen::Vector3d(kRing_m * std::cos(angle), kRing_m * std::sin(angle), 0.0);
    });
  return paths;
}

/// The ring's radius as it is felt so long after a snapshot, seen from outside. lag_s: of the angle
/// at which it is displayed.
double felt_radius(display::Transition transition, std::uint64_t after_ns, double lag_s) {
  MovingBody ring(transition, turning_ring());
  ring.run(after_ns);
  const Eigen::Vector3d there_m = ring.paths[0](seconds(ring.now_ns) - lag_s);
  return ring.seen_m(1.2 * there_m).norm() / kRing_m;
}

TEST_CASE("2.3 A body that turns half a radian a period shrinks by 3.109 % on linear's chord",
          "[shape]") {
  CHECK(1.0 - std::cos(0.25) == Approx(0.03109).epsilon(1e-3));
  CHECK(1.0 - felt_radius(display::Transition::kLinear, kPeriod_ns / 2, kPeriod_s) ==
        Approx(0.03109).epsilon(1e-3));
  CHECK(felt_radius(display::Transition::kLinear, 0, kPeriod_s) == Approx(1.0).epsilon(1e-5));
}

/// A row of spheres that stretches and bends, each sphere at its own steady speed.
std::vector<Path> deforming_row() {
  std::vector<Path> paths;
  for (int i = 0; i < 5; ++i)
    paths.push_back([i](double t) {
      const double x_m = 0.05 * i;
      return Eigen::Vector3d(x_m * (1.0 + 0.5 * t), 0.02 * i * i * t, 0.01 * i * t);
    });
  return paths;
}

TEST_CASE("A deforming body has the shape of one instant, a period ago", "[shape]") {
  const std::uint64_t after_ns = GENERATE(as<std::uint64_t>(), 3, 17, 29) * kMillisecond_ns;
  MovingBody body(display::Transition::kLinear, deforming_row());
  body.run(after_ns);
  for (const Path& path : body.paths) {
    const Eigen::Vector3d there_m = path(seconds(body.now_ns) - kPeriod_s);
    CHECK((body.seen_m(there_m + Eigen::Vector3d(0.001, 0.002, 0.016)) - there_m).norm() < 2e-7);
  }
}

}  // namespace
}  // namespace stillgrid::rendering::shape_test

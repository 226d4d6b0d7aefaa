// Spheres that appear and vanish: absent from a snapshot in which their position is not a number.

#include <catch2/catch.hpp>
#include <limits>

#include "shared/rendering/renderer.hpp"
#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::presence_test {
namespace {

constexpr std::uint64_t kPeriod_ns = 32 * kMillisecond_ns;
constexpr double kFull_N = 500.0 * 0.004;

Eigen::Vector3d absent() {
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// A sphere of 10 mm pressed 4 mm deep by a tool of 10 mm where it is present, one far away, and
/// one that never comes.
struct Visitor {
  PublishedScene scene{plain_scene(500.0F, 0.01F), {0.01F, 0.01F, 0.01F}, kPeriod_ns};
  std::unique_ptr<Renderer> renderer;
  std::uint64_t now_ns = 0;
  Eigen::Vector3d place_m = Eigen::Vector3d(0.3, 0.0, 0.0);

  explicit Visitor(display::Transition transition) : renderer(make_renderer(transition)) {}

  void show(bool is_present) {
    const Eigen::Vector3d away_m(0.3, 1.0, 0.0);
    const Eigen::Vector3d still = Eigen::Vector3d::Zero();
    scene.show({is_present ? place_m : absent(), away_m, absent()},
               {is_present ? still : absent(), still, still}, now_ns);
  }
  RenderedTick tick() const {
    return renderer->render(scene.view(), {.position_m = {0.3, 0.0, 0.016}}, now_ns);
  }
  /// The forces of so many ticks from now on.
  std::vector<double> forces_N(int ticks = 32) {
    std::vector<double> forces;
    for (int i = 0; i < ticks; ++i, now_ns += kMillisecond_ns) {
      forces.push_back(tick().force.force_N.z());
      REQUIRE(tick().force.force_N.allFinite());
    }
    return forces;
  }
};

TEST_CASE("Held snapshots show a sphere that appears at once, and one that vanishes no more",
          "[presence]") {
  Visitor visitor(display::Transition::kHold);
  visitor.show(false);
  CHECK(visitor.forces_N() == std::vector<double>(32, 0.0));
  visitor.show(true);
  for (const double force_N : visitor.forces_N()) CHECK(force_N == Approx(kFull_N).epsilon(1e-5));
  visitor.show(false);
  CHECK(visitor.forces_N() == std::vector<double>(32, 0.0));
}

TEST_CASE("A sphere that appears or vanishes is felt by the weights of the snapshots it is in",
          "[presence]") {
  Visitor visitor(display::Transition::kLinear);
  for (int i = 0; i < 5; ++i) {
    visitor.show(false);
    CHECK(visitor.forces_N() == std::vector<double>(32, 0.0));
  }
  visitor.show(true);
  const std::vector<double> coming_N = visitor.forces_N();
  for (std::size_t i = 0; i < 32; ++i)
    CHECK(coming_N[i] == Approx(kFull_N * static_cast<double>(i) / 32.0).epsilon(1e-5));
  visitor.show(true);
  CHECK(visitor.forces_N().back() == Approx(kFull_N).epsilon(1e-5));
  visitor.show(false);
  const std::vector<double> going_N = visitor.forces_N();
  for (std::size_t i = 0; i < 32; ++i)
    CHECK(going_N[i] == Approx(kFull_N * (1.0 - static_cast<double>(i) / 32.0)).epsilon(1e-5));
  visitor.show(false);
  CHECK(visitor.forces_N() == std::vector<double>(32, 0.0));
}

TEST_CASE("It is displayed where it was or will be, not drawn to where it is not", "[presence]") {
  Visitor visitor(display::Transition::kLinear);
  visitor.show(false);
  visitor.forces_N();
  visitor.place_m.x() += 0.006;
  visitor.show(true);
  visitor.forces_N(16);
  const Eigen::Vector3d force_N = visitor.tick().force.force_N;
  CHECK(force_N.x() / force_N.z() == Approx(-0.006 / 0.016).epsilon(1e-4));
}

}  // namespace
}  // namespace stillgrid::rendering::presence_test

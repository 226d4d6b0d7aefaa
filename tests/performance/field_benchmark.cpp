// What a tick costs that touches a ball by its distance field, beside the same ball covered with
// spheres: hot, and with caches flushed, as the tick of a millisecond later finds them.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "shared/collision/field_history.hpp"
#include "shared/collision/sphere_history.hpp"
#include "shared/rendering/placed_tool.hpp"
#include "shared/rendering/renderer.hpp"
#include "shared/rendering/touched_fields.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

using Eigen::Vector3d;

constexpr double kBall_m = 0.05, kProbe_m = 0.005, kDepth_m = 0.001;
constexpr std::uint64_t kPeriod_ns = 33'000'000;

/// A place on the ball, evenly over it.
Vector3d on_ball(std::size_t i, std::size_t count) {
  const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
  const double turn_rad = 2.399963229728653 * static_cast<double>(i), r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn_rad), r * std::sin(turn_rad), z};
}

/// The ball with so many spheres on its surface, or by its field of such cells.
struct Ball {
  std::size_t spheres = 0;
  double cell_m = 0.0;
  bool moves = false;
};

proto::SphereRecord sphere_of(std::size_t i, std::size_t count) {
  // A sphere's radius is the spacing, so that none but its neighbours lie beneath the tool.
  const double radius_m = kBall_m * std::sqrt(4.0 * M_PI / static_cast<double>(count));
  const Eigen::Vector3f p = ((kBall_m - radius_m) * on_ball(i, count)).cast<float>();
  proto::SphereRecord record{};
  collision::fill_history(record, {{p.x(), p.y(), p.z()}, {}});
  record.radius_m = static_cast<float>(radius_m);
  return record;
}

publication::PublishedField field_of(const Ball& ball) {
  publication::PublishedField field;
  const Vector3d half_m = Vector3d::Constant(kBall_m);
  field.field = std::make_shared<collision::DistanceField>(
      collision::make_field({-half_m, half_m}, {ball.cell_m, kProbe_m, 2.0 * kProbe_m},
                            [](const Vector3d& p) { return p.norm() - kBall_m; }));
  field.body.rest.orientation_xyzw = {0.0F, 0.6F, 0.0F, 0.8F};
  field.body.moving = ball.moves ? 1 : 0;
  return field;
}

publication::StaticScene scene_of(const Ball& ball) {
  publication::StaticScene scene;
  scene.name = "ball";
  scene.materials = {{700.0F, 1.0F, 0.1F, 1e-3F}};
  scene.tool = {{{}, static_cast<float>(kProbe_m)}};
  scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, 1.0};
  if (ball.cell_m > 0.0) scene.fields.push_back(field_of(ball));
  for (std::size_t i = 0; i < ball.spheres && !ball.moves; ++i)
    scene.spheres.push_back(sphere_of(i, ball.spheres));
  return scene;
}

/// Of one scene in a segment of its own.
class Tick {
 public:
  explicit Tick(const Ball& ball)
      : session_("field-benchmark-" + std::to_string(::getpid()) + "-" + std::to_string(count_++)),
        scene_(scene_of(ball)),
        moving_(ball.moves ? ball.spheres : 0),
        writer_(session_, scene_, moving_, kPeriod_ns, proto::Clock::kVirtual, 0),
        view_(*publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                proto::kSceneLayoutHash)) {
    collision::VoxelGrid snapshot(sizeof(proto::SnapshotHeader), moving_);
    for (std::size_t i = 0; i < moving_; ++i) snapshot.records()[i] = sphere_of(i, moving_);
    snapshot.enter(collision::history_bounds(snapshot.records()), 1.0F);
    std::vector<proto::FieldRecord> fields(view_.moving_fields());
    for (proto::FieldRecord& field : fields)
      collision::fill_history(field, scene_.fields[0].body.rest);
    writer_.publish(snapshot, {.state_ns = kPeriod_ns, .publish_ns = kPeriod_ns}, fields);
  }
  ~Tick() {
    ::unlink(
        (publication::own_segment_path(session_, proto::SegmentKind::kScene) + ".lock").c_str());
  }
  Tick(const Tick&) = delete;
  Tick& operator=(const Tick&) = delete;
  Tick(Tick&&) = delete;
  Tick& operator=(Tick&&) = delete;

  [[nodiscard]] rendering::RenderedTick render(rendering::Renderer& renderer,
                                               const Vector3d& tool_m) const {
    return renderer.render(view_, {.position_m = tool_m}, kPeriod_ns + 5'000'000);
  }
  /// What the tick asks of the field alone.
  [[nodiscard]] double probe_m(const Vector3d& tool_m) const {
    const auto contact = collision::field_contact(view_.fields().front().field, tool_m, kProbe_m);
    return contact ? contact->depth_m : 0.0;
  }

 private:
  inline static int count_ = 0;
  std::string session_;
  publication::StaticScene scene_;
  std::size_t moving_;
  publication::SceneWriter writer_;
  publication::SceneView view_;
};

/// Where the tool presses: a small circle, or anywhere on the ball.
Vector3d creeping_m(std::size_t i) {
  const double turn_rad = 6.2832 * static_cast<double>(i % 1024) / 1024.0;
  return (kBall_m + kProbe_m - kDepth_m) *
         Vector3d(0.02 * std::cos(turn_rad), 0.02 * std::sin(turn_rad), 1.0).normalized();
}
Vector3d anywhere_m(std::size_t i) {
  return (kBall_m + kProbe_m - kDepth_m) * on_ball((i * 7919) % 10007, 10007);
}

/// Times what `look` does at each place with caches flushed before it; the look at the clock apart.
template <class Place, class Look>
void time_flushed(benchmark::State& state, Place&& place_m, Look&& look) {
  CacheFlush flush;
  std::vector<double> times_s, clock_s;
  std::size_t i = 0;
  for (auto _ : state) {
    const Vector3d tool_m = place_m(i++);
    flush();
    clock_s.push_back(seconds_of([] {}));
    times_s.push_back(seconds_of([&] { look(tool_m); }));
    state.SetIterationTime(times_s.back());
  }
  const auto median_ns = [](std::vector<double>& values_s) {
    std::nth_element(values_s.begin(), values_s.begin() + std::ssize(values_s) / 2, values_s.end());
    return 1e9 * values_s[values_s.size() / 2];
  };
  state.counters["median_ns"] = median_ns(times_s);
  state.counters["clock_ns"] = median_ns(clock_s);
}

void add_probes(const std::string& name, double cell_m) {
  const auto tick = std::make_shared<Tick>(Ball{.cell_m = cell_m});
  benchmark::RegisterBenchmark(("probe_hot/" + name).c_str(), [tick](benchmark::State& state) {
    std::size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(tick->probe_m(creeping_m(i++)));
  });
  benchmark::RegisterBenchmark(("probe_flushed/" + name).c_str(),
                               [tick](benchmark::State& state) {
                                 time_flushed(state, anywhere_m, [&](const Vector3d& tool_m) {
                                   benchmark::DoNotOptimize(tick->probe_m(tool_m));
                                 });
                               })
      ->UseManualTime()
      ->Iterations(60);
}

void add_ticks(const std::string& name, const Ball& ball) {
  const auto tick = std::make_shared<Tick>(ball);
  for (const auto transition : {display::Transition::kLinear, display::Transition::kLocal}) {
    const std::string of = name + "/" + std::string(display::name_of(transition));
    const auto felt = [tick, transition](benchmark::State& state, auto&& run) {
      const auto renderer = rendering::make_renderer(transition);
      const rendering::RenderedTick first = tick->render(*renderer, creeping_m(0));
      if (first.force.contacts == 0) return state.SkipWithError("nothing is touched");
      state.counters["contacts"] = first.force.contacts;
      run(*renderer);
    };
    benchmark::RegisterBenchmark(("tick_hot/" + of).c_str(), [tick, felt](benchmark::State& state) {
      felt(state, [&](rendering::Renderer& renderer) {
        std::size_t i = 0;
        for (auto _ : state) benchmark::DoNotOptimize(tick->render(renderer, creeping_m(i++)));
      });
    });
    benchmark::RegisterBenchmark(("tick_flushed/" + of).c_str(),
                                 [tick, felt](benchmark::State& state) {
                                   felt(state, [&](rendering::Renderer& renderer) {
                                     time_flushed(state, creeping_m, [&](const Vector3d& tool_m) {
                                       benchmark::DoNotOptimize(tick->render(renderer, tool_m));
                                     });
                                   });
                                 })
        ->UseManualTime()
        ->Iterations(60);
  }
}

int program_main(int argc, char** argv) {
  add_probes("cells_of_2_mm", 0.002);
  add_probes("cells_of_0.5_mm", 0.0005);
  for (const bool moves : {false, true}) {
    const std::string how = moves ? "/moving" : "/static";
    add_ticks("field" + how, {.cell_m = 0.001, .moves = moves});
    add_ticks("400_spheres" + how, {.spheres = 400, .moves = moves});
    add_ticks("10000_spheres" + how, {.spheres = 10000, .moves = moves});
  }
  benchmark::Initialize(&argc, argv);
  benchmark::AddCustomContext("last_cache_mb", std::to_string(last_cache_bytes() >> 20));
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}

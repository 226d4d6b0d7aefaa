// What a tick of the renderer costs with caches flushed before it, as the tick of a millisecond
// later finds them, of every model in turn on the same snapshots: a row of CSV each. Times include
// a look at the clock, which the last row tells.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "shared/publication/scene_segment.hpp"
#include "shared/tools/laboratory/rivals/rivals.hpp"
#include "sim_server/published_scene.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

constexpr std::uint64_t kTick_ns = 1'000'000;
/// Ticks; a flush takes many times as long as what it delays.
constexpr std::uint64_t kTimedEach = 19;

struct Measured {
  std::string name;
  std::unique_ptr<rendering::Renderer> renderer;
  std::vector<double> standing_s, new_snapshot_s;  // ticks in contact
};

std::vector<Measured> all_models() {
  std::vector<Measured> all;
  for (const display::TransitionLaw& law : display::transitions())
    all.push_back({std::string(law.name), rendering::make_renderer(law.transition), {}, {}});
  for (const laboratory::Rival& rival : laboratory::rivals())
    all.push_back({std::string(rival.name), rival.make(), {}, {}});
  return all;
}

/// A tick a line, from time zero: time_s,x_m,y_m,z_m after a head, device frame.
std::vector<Eigen::Vector3d> read_path(const std::string& file, const scene::DeviceFrame& frame) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::vector<Eigen::Vector3d> places_m;
  while (std::getline(stream, line)) {
    Eigen::Vector3d place_m;
    if (std::sscanf(line.c_str(), "%*f,%lf,%lf,%lf", &place_m.x(), &place_m.y(), &place_m.z()) != 3)
      throw std::runtime_error(file + ": line '" + line + "': expected time_s,x_m,y_m,z_m");
    places_m.push_back(frame.position_m + frame.scale * (frame.orientation * place_m));
  }
  if (places_m.size() < 2) throw std::runtime_error(file + ": expected a path");
  return places_m;
}

void time_tick(Measured& measured, const publication::SceneView& view,
               const rendering::ToolPose& pose, std::uint64_t now_ns, CacheFlush* flush) {
  if (flush != nullptr) (*flush)();
  rendering::RenderedTick tick;
  const double took_s = seconds_of([&] { tick = measured.renderer->render(view, pose, now_ns); });
  if (flush == nullptr || tick.force.contacts == 0) return;
  (tick.is_new ? measured.new_snapshot_s : measured.standing_s).push_back(took_s);
}

double percentile_us(std::vector<double>& times_s, double share) {
  if (times_s.empty()) return std::nan("");
  const auto place = times_s.begin() +
                     static_cast<std::ptrdiff_t>(share * static_cast<double>(times_s.size() - 1));
  std::nth_element(times_s.begin(), place, times_s.end());
  return 1e6 * *place;
}

void print(const std::string& name, std::vector<double>& standing_s,
           std::vector<double>& new_snapshot_s) {
  std::printf("%s,%.3f,%.3f,%.3f,%.3f,%zu\n", name.c_str(), percentile_us(standing_s, 0.5),
              percentile_us(standing_s, 0.99), percentile_us(new_snapshot_s, 0.5),
              percentile_us(new_snapshot_s, 0.99), standing_s.size() + new_snapshot_s.size());
}

/// Simulation and ticks in turn; every model sees every tick. A step costs nothing here.
void measure(const std::string& scene_file, const std::string& path_file, double from_s) {
  const scene::SceneDescription scene = scene::load_scene(scene_file);
  const std::vector<Eigen::Vector3d> path_m = read_path(path_file, scene.device);
  dynamics::Simulation simulation(scene);
  const auto period_ns = static_cast<std::uint64_t>(1e9 * scene.period_s);
  const std::string session = "cold-tick-" + std::to_string(::getpid());
  publication::SceneWriter writer(session, sim_server::static_scene(scene, simulation),
                                  simulation.world().spheres.size(), period_ns,
                                  proto::Clock::kVirtual, 0);
  const publication::SceneView view(*publication::SegmentReader::open(
      session, proto::SegmentKind::kScene, proto::kSceneLayoutHash));
  std::vector<Measured> models = all_models();
  CacheFlush flush;
  std::uint64_t snapshot_ns = 0;
  for (std::size_t i = 0; i < path_m.size(); ++i) {
    const std::uint64_t now_ns = i * kTick_ns;
    const rendering::ToolPose pose{.position_m = path_m[i]};
    if (now_ns >= snapshot_ns) {
      const bool is_first = snapshot_ns == 0;
      writer.publish(
          simulation.snapshot(),
          {.state_ns = snapshot_ns, .publish_ns = snapshot_ns, .tool_ns = snapshot_ns},
          is_first ? publication::SnapshotPrediction{} : simulation.predict_next(scene.period_s),
          simulation.field_records());
      snapshot_ns += period_ns;
      simulation.step(scene.period_s, [&]() -> std::optional<dynamics::ToolSample> {
        const auto place_m = path_m[std::min(snapshot_ns / kTick_ns, path_m.size() - 1)];
        return dynamics::ToolSample{snapshot_ns, place_m, Eigen::Quaterniond::Identity(),
                                    Eigen::Vector3d::Zero()};
      });
    }
    const bool is_timed = static_cast<double>(i) * 1e-3 >= from_s && i % kTimedEach == 0;
    for (Measured& measured : models)
      time_tick(measured, view, pose, now_ns, is_timed ? &flush : nullptr);
  }
  std::printf(
      "model,standing_p50_us,standing_p99_us,new_snapshot_p50_us,new_snapshot_p99_us,ticks\n");
  for (Measured& measured : models)
    print(measured.name, measured.standing_s, measured.new_snapshot_s);
  std::vector<double> clock_s(1000), none;
  for (double& time_s : clock_s) time_s = seconds_of([] {});
  print("clock", clock_s, none);
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: cold_tick_figures SCENE.toml PATH.csv FROM_S\n");
    return 2;
  }
  try {
    stillgrid::performance::measure(argv[1], argv[2], std::stod(argv[3]));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cold_tick_figures: %s\n", error.what());
    return 1;
  }
}

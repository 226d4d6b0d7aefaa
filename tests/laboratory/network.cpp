#include "tests/laboratory/network.hpp"

#include "sim_server/published_scene.hpp"

namespace stillgrid::laboratory {
namespace {

/// Of the two ways of one network.
constexpr std::uint64_t kToolSeed = 0x9e3779b97f4a7c15, kSceneSeed = 0xc2b2ae3d27d4eb4f;

std::optional<scene_relay::Deadband> deadband_of(const NetworkOptions& options) {
  if (!(options.deadband > 0.0)) return std::nullopt;
  return scene_relay::Deadband({.velocity_share = options.deadband});
}

}  // namespace

Network::Network(const scene::SceneDescription& scene, const dynamics::Simulation& simulation,
                 const NetworkOptions& options, std::uint64_t seed)
    : remote_(scene, simulation,
              options.told_period_s > 0.0 ? options.told_period_s : scene.period_s),
      view_(remote_.view()),
      deadband_(deadband_of(options)),
      tool_link_(options.path, seed ^ kToolSeed),
      snapshot_link_(options.path, options.snapshot_bytes, seed ^ kSceneSeed,
                     options.kept_snapshots) {}

void Network::send(const proto::ToolState& tool) {
  ++figures_.samples;
  if (deadband_ && !deadband_->must_send(tool)) return;
  ++figures_.samples_sent;
  tool_link_.send(tool);
}

std::optional<dynamics::ToolSample> Network::tool_at(std::uint64_t now_ns) {
  const std::optional<ArrivedSample>& newest = tool_link_.newest(now_ns);
  if (!newest) return std::nullopt;
  if (!deadband_) return sim_server::sample_of(newest->sample);
  return sim_server::sample_of(scene_relay::led_on(newest->sample, now_ns - newest->arrival_ns));
}

void Network::send(const dynamics::Simulation& simulation,
                   const publication::SnapshotTimes& times) {
  ++figures_.snapshots;
  snapshot_link_.send(sent_snapshot(simulation, times));
}

void Network::deliver(std::uint64_t now_ns) {
  for (const ArrivedSnapshot& arrived : snapshot_link_.take(now_ns)) {
    remote_.show(arrived.snapshot, arrived.arrival_ns);
    ++figures_.snapshots_shown;
  }
}

NetworkFigures Network::figures() const noexcept {
  NetworkFigures figures = figures_;
  figures.replaced = snapshot_link_.replaced();
  figures.late = snapshot_link_.late();
  return figures;
}

}  // namespace stillgrid::laboratory

#include "sim_server/lockstep_simulation.hpp"

#include <unistd.h>

#include <atomic>
#include <utility>

#include "shared/realtime/periodic_timer.hpp"
#include "sim_server/published_scene.hpp"

namespace stillgrid::sim_server {
namespace {

std::string unique_session() {
  static std::atomic<int> count = 0;
  return "lockstep-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
}

}  // namespace

LockstepSimulation::LockstepSimulation(const scene::SceneDescription& scene, bodies::World world,
                                       LockstepSchedule schedule, CostClock now_s,
                                       std::span<const std::byte> contacts)
    : session_(unique_session()),
      clock_s_(std::move(now_s)),
      simulation_(scene, std::move(world)),
      writer_(session_, static_scene(scene, simulation_), simulation_.world().spheres.size(),
              realtime::to_ns(scene.period_s), proto::Clock::kVirtual, 0),
      schedule_(std::move(schedule)),
      snapshot_(schedule_.next()) {
  simulation_.set_contact_state(contacts);
  if (writer_.scene().model_bytes > 0) paths_.emplace(simulation_, 0, scene.period_s);
  writer_.publish(simulation_.snapshot(), {.state_ns = 0, .publish_ns = 0},
                  simulation_.field_records(),
                  paths_ ? paths_->state() : publication::SnapshotState());
}

publication::SceneView LockstepSimulation::view() const {
  return publication::SceneView(publication::SegmentReader::require(
      session_, proto::SegmentKind::kScene, proto::kSceneLayoutHash));
}

void LockstepSimulation::run_to(std::uint64_t now_ns, bool at_now,
                                const dynamics::TakeTool& take_tool, const AfterStep& after_step,
                                const AfterPublication& after_publication) {
  while (true) {
    if (!times_) {
      if (snapshot_.sample_ns > now_ns || (snapshot_.sample_ns == now_ns && !at_now)) return;
      step(take_tool, after_step);
    }
    if (times_->publish_ns > now_ns) return;
    const double began_s = now_s();
    writer_.publish(simulation_.snapshot(), *times_, simulation_.field_records(), state());
    if (clock_s_) step_s_.back() += now_s() - began_s;
    if (after_publication) after_publication(simulation_, *times_);
    times_.reset();
    snapshot_ = schedule_.next();
  }
}

dynamics::StepReport LockstepSimulation::step_to_state(const dynamics::TakeTool& tool) {
  if (!is_followed()) return simulation_.step(static_cast<double>(snapshot_.step_ns) * 1e-9, tool);
  paths_->follow(0, tool_);
  const dynamics::StepReport report = paths_->step_until(snapshot_.state_ns, simulation_, {});
  snapshot_.state_ns = paths_->time_ns();
  return report;
}

void LockstepSimulation::step(const dynamics::TakeTool& take_tool, const AfterStep& after_step) {
  const double began_s = now_s();
  const dynamics::StepReport report = step_to_state(take_tool);
  times_ = times_of(snapshot_, report);
  if (clock_s_) step_s_.push_back(now_s() - began_s);
  if (after_step) after_step(simulation_, report);
}

}  // namespace stillgrid::sim_server

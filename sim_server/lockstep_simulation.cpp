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
                                       double prediction_s, bool with_state)
    : session_(unique_session()),
      predicts_(predicts(scene) && prediction_s != kNoPrediction),
      prediction_s_(prediction_s > 0.0 ? prediction_s : scene.period_s),
      clock_s_(std::move(now_s)),
      simulation_(scene, std::move(world)),
      with_state_(with_state && can_be_local(scene, simulation_)),
      writer_(session_, static_scene(scene, simulation_, 0, with_state_),
              simulation_.world().spheres.size(), realtime::to_ns(scene.period_s),
              proto::Clock::kVirtual, 0),
      schedule_(std::move(schedule)),
      snapshot_(schedule_.next()) {
  predicts_ = predicts_ && !with_state_;
  if (with_state_) paths_.emplace(simulation_, 0);
  writer_.publish(simulation_.snapshot(), {.state_ns = 0, .publish_ns = 0}, {},
                  simulation_.field_records(), state());
}

publication::SceneView LockstepSimulation::view() const {
  auto reader = publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                 proto::kSceneLayoutHash);
  if (!reader) throw publication::SegmentError("the session '" + session_ + "' is gone");
  return publication::SceneView(std::move(*reader));
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
    writer_.publish(simulation_.snapshot(), *times_, prediction_, simulation_.field_records(),
                    state());
    if (clock_s_) step_s_.back() += now_s() - began_s;
    if (after_publication) after_publication(simulation_, *times_, prediction_);
    times_.reset();
    snapshot_ = schedule_.next();
  }
}

dynamics::StepReport LockstepSimulation::step_to_state(const dynamics::TakeTool& tool) {
  if (!paths_) return simulation_.step(static_cast<double>(snapshot_.step_ns) * 1e-9, tool);
  paths_->follow(0, tool_);
  const dynamics::StepReport report = paths_->step_until(snapshot_.state_ns, simulation_, {});
  snapshot_.state_ns = paths_->time_ns();
  return report;
}

void LockstepSimulation::step(const dynamics::TakeTool& take_tool, const AfterStep& after_step) {
  const double began_s = now_s();
  const dynamics::StepReport report = step_to_state(take_tool);
  times_ = times_of(snapshot_, report);
  if (predicts_) prediction_ = simulation_.predict_next(prediction_s_);
  if (clock_s_) step_s_.push_back(now_s() - began_s);
  if (after_step) after_step(simulation_, report);
}

}  // namespace stillgrid::sim_server

#include "shared/tools/scene_viewer/tool_sampler.hpp"

#include "shared/realtime/periodic_timer.hpp"

namespace stillgrid::scene_viewer {
namespace {

/// Not a millisecond: beside a loop of the same period one that is a little late at times would
/// miss many ticks.
constexpr std::uint64_t kPeriod_ns = 800'000;
constexpr std::uint64_t kSamplesPerFollow = 40;  // 32 ms

}  // namespace

ToolSampler::ToolSampler(const std::string& session, TimeAxis real_axis)
    : follower_(session, proto::SegmentKind::kTool), real_axis_(real_axis) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void ToolSampler::run(const std::stop_token& stop) {
  realtime::PeriodicTimer timer(kPeriod_ns);
  for (std::uint64_t i = 0; !stop.stop_requested(); ++i, timer.wait()) {
    if (i % kSamplesPerFollow == 0) follow();
    sample();
  }
}

void ToolSampler::follow() {
  follower_.look();
  const std::lock_guard lock(mutex_);
  look_.hand = follower_.life();
  look_.relay = follower_.relay();
  look_.refusal = follower_.refusal();
}

void ToolSampler::sample() {
  const publication::ToolView* tool = follower_.tool();
  if (tool == nullptr) return;
  auto state = tool->read();
  if (!state) return;
  if (!publication::has_sound_figures(*state)) state->before = {};
  if (epoch_ != tool->header().epoch) {
    epoch_ = tool->header().epoch;
    before_ = last_;
  }
  state->tick += before_;
  if (state->tick <= last_) return;
  last_ = state->tick;

  const proto::TickFigures& figures = state->before;
  const TimeAxis axis = axis_of(tool->header().clock, real_axis_);
  history_.add({.tick = state->tick,
                .time_s = axis.seconds(state->time_ns),
                .position_m = state->position_m,
                .force_N = state->force_N,
                .age_s = figures.displayed.age_s,
                .work_us = static_cast<double>(figures.work_ns) * 1e-3,
                .wake_us = static_cast<double>(figures.wake_up_latency_ns) * 1e-3,
                .flags = figures.flags,
                .contacts = figures.contacts,
                .snapshot_id = figures.displayed.snapshot_id,
                .missed = figures.missed_ticks});
  const std::lock_guard lock(mutex_);
  look_.state = state;
  look_.clock = tool->header().clock;
  look_.period_ns = tool->header().period_ns;
  look_.epoch = epoch_;
  look_.writer_pid = tool->header().writer_pid;
}

ToolLook ToolSampler::look() const {
  const std::lock_guard lock(mutex_);
  return look_;
}

}  // namespace stillgrid::scene_viewer

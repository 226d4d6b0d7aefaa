#include "shared/tools/scene_viewer/live_view.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "shared/publication/hands.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/segment_inspect/inspection_text.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr std::size_t kMaxScenes = 16;
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
/// A tick that displays a new snapshot comes a millisecond or two after it.
constexpr int kMaxLooks = 5;

}  // namespace

LiveView::LiveView(const LiveOptions& options)
    : options_(options),
      real_axis_{realtime::monotonic_ns()},
      sampler_(options.session, real_axis_),
      follower_(options.session, proto::SegmentKind::kScene),
      others_(options.session),
      sim_command_(options.session),
      hand_command_(options.session) {
  if (!options.save.empty()) writer_ = std::make_unique<ViewWriter>(options.save);
  scenes_.emplace_back("", std::make_shared<const std::string>(
                               empty_scene_message(ViewKind::kSession, options.session, "")));
  capture();  // whoever asks first is shown something
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void LiveView::run(const std::stop_token& stop) {
  realtime::PeriodicTimer timer(realtime::to_ns(1.0 / options_.frames_per_s));
  for (timer.wait(); !stop.stop_requested(); timer.wait()) capture();
}

/// The newest snapshot, and if the loop lives the state of a tick that displayed it.
void LiveView::read_newest(Frame& frame, ToolLook& tool) {
  const publication::SceneView* scene = follower_.scene();
  if (scene == nullptr) return;
  if (reader_.turn_to(*scene)) snapshot_.reset();
  for (int i = 0; i < kMaxLooks; ++i) {
    const std::uint64_t shown = tool.state ? tool.state->before.displayed.snapshot_id : 0;
    if (!snapshot_ || shown >= snapshot_->snapshot_id || i == 0)
      if (auto newest = reading::read_snapshot(reader_, *scene, kAll))
        snapshot_ = std::move(newest);
    const bool is_behind = snapshot_ && tool.state && shown < snapshot_->snapshot_id &&
                           tool.state->before.displayed.scene_epoch == reader_.epoch();
    if (!is_behind || tool.hand != reading::Life::kAlive || tool.clock == proto::Clock::kVirtual)
      break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    tool = sampler_.look();
  }
  frame.snapshot = snapshot_;
  frame.scene_epoch = reader_.epoch();
}

/// Another key with another number of spheres too: before the first snapshot there are none.
void LiveView::set_scene(Frame& frame, const ToolLook& tool) {
  if (follower_.scene() == nullptr) return;
  const std::vector<proto::SphereRecord> none;
  const auto& moving = frame.snapshot ? frame.snapshot->spheres : none;
  frame.scene_key = segment_inspect::hexadecimal(frame.scene_epoch) + "-" +
                    std::to_string(moving.size()) + (tool.period_ns != 0 ? "-h" : "");
  if (scenes_.back().first == frame.scene_key) return;  // written by this thread only
  const auto message = std::make_shared<const std::string>(
      scene_message(*follower_.scene(), options_.session, frame.scene_key, moving,
                    options_.surfaces, tool.period_ns));
  const std::lock_guard lock(mutex_);
  scenes_.emplace_back(frame.scene_key, message);
  // Not the first, which frames without a scene have.
  if (scenes_.size() > kMaxScenes) scenes_.erase(scenes_.begin() + 1);
}

/// While a server lives: when it is dead the system has forgotten it.
void LiveView::learn_commands(const ToolLook& tool) {
  if (follower_.life() == reading::Life::kAlive && follower_.scene() != nullptr)
    sim_command_.look(follower_.scene()->header().epoch, follower_.scene()->header().writer_pid);
  if (tool.hand == reading::Life::kAlive && tool.epoch != 0)
    hand_command_.look(tool.epoch, tool.writer_pid);
}

Frame LiveView::look() {
  follower_.look();
  Frame frame;
  frame.number = next_frame_++;
  ToolLook tool = sampler_.look();
  read_newest(frame, tool);
  set_scene(frame, tool);
  learn_commands(tool);
  frame.sim = follower_.life();
  frame.hand = tool.hand;
  frame.sim_relay = follower_.relay();
  frame.hand_relay = tool.relay;
  frame.tool = tool.state;
  frame.others = others_.look();
  frame.ticks = sampler_.history().summary();
  const publication::SceneView* scene = follower_.scene();
  const bool is_virtual = scene != nullptr ? scene->header().clock == proto::Clock::kVirtual
                                           : tool.clock == proto::Clock::kVirtual;
  frame.axis = is_virtual ? TimeAxis{} : real_axis_;
  frame.now_ns = realtime::monotonic_ns();
  if (is_virtual)
    frame.now_ns = std::max(frame.snapshot ? frame.snapshot->header.publish_time_ns[0] : 0,
                            frame.tool ? frame.tool->time_ns : 0);
  tell(frame, tool);
  return frame;
}

/// That there is no such hand, or no simulation yet.
std::string LiveView::note_of_absence() const {
  try {
    publication::require_hand(options_.session);
  } catch (const publication::SegmentError& error) {
    return error.what();
  }
  return "waiting for a sim_server in session '" + options_.session + "'";
}

/// What has changed, on the log and for /api/status.
void LiveView::tell(const Frame& frame, const ToolLook& tool) {
  std::string note = !follower_.refusal().empty() ? "sim_server's segment: " + follower_.refusal()
                     : !tool.refusal.empty()      ? "haptic_server's segment: " + tool.refusal
                                                  : "";
  if (note.empty() && frame.sim == reading::Life::kAbsent && follower_.scene() == nullptr)
    note = note_of_absence();
  const std::string line =
      note.empty() ? fmt::format("simulation {}, hand {}", name_of(frame.sim), name_of(frame.hand))
                   : note;
  if (line != told_) spdlog::info("{}", line);
  told_ = line;
  const std::lock_guard lock(mutex_);
  status_ = {.live = true,
             .first_frame = 0,
             .last_frame = 0,
             .sim = frame.sim,
             .hand = frame.hand,
             .now_s = frame.axis.seconds(frame.now_ns),
             .scene_key = frame.scene_key,
             .note = note,
             .sim_command = sim_command_.line(),
             .hand_command = hand_command_.line()};
}

void LiveView::save(const std::string& key, const std::string& frame) {
  if (!writer_) return;
  const auto samples = sampler_.history().from(next_saved_tick_, kAll);
  if (!samples.empty()) next_saved_tick_ = samples.back().tick + 1;
  try {
    if (std::exchange(saved_key_, key) != key) writer_->add(ViewRecord::kScene, *scene(key));
    writer_->add(samples);
    writer_->add(ViewRecord::kFrame, frame);
  } catch (const std::exception& error) {
    spdlog::warn("{}; nothing more is saved", error.what());
    writer_.reset();
  }
}

void LiveView::capture() {
  const Frame frame = look();
  std::string message = frame_message(frame);
  save(frame.scene_key, message);
  frames_.add(std::move(message), static_cast<double>(realtime::monotonic_ns()) * 1e-9);
}

ViewStatus LiveView::status() const {
  ViewStatus status;
  {
    const std::lock_guard lock(mutex_);
    status = status_;
  }
  status.first_frame = frames_.first();
  status.last_frame = frames_.last();
  return status;
}

Message LiveView::scene(std::optional<std::string_view> key) const {
  const std::lock_guard lock(mutex_);
  if (!key) return scenes_.back().second;
  for (const auto& [own, message] : scenes_)
    if (own == *key) return message;
  return nullptr;
}

Message LiveView::frame(std::optional<std::uint64_t> number) const {
  return frames_.get(number);
}

std::string LiveView::ticks(std::uint64_t from, std::size_t most) const {
  return tick_message(sampler_.history().from(from, most));
}

}  // namespace stillgrid::scene_viewer

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "shared/publication/relay_figures.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/relay.hpp"
#include "shared/tools/scene_relay/shown_tool.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"
#include "shared/tools/scene_relay/tool_messages.hpp"

namespace stillgrid::scene_relay {
namespace {

/// Of so many bytes one in twelve is lost at 1 %, and the next comes as soon as what was lost: at
/// such a step. Of faster ones several have come by then, so that as many more packets are few.
constexpr std::uint64_t kFewPackets_bytes = 8 * 1344;
constexpr std::uint64_t kFewOfStep_ns = 33'333'333;
/// What the other side may take to answer, beside the round trip.
constexpr std::uint64_t kAnswer_ns = 30'000'000;

class SimulationSide {
 public:
  SimulationSide(const RelayOptions& options, RelayReport& report)
      : options_(options),
        report_(report),
        link_(options, Role::kSimulation, report),
        encoder_(link_.relay_id(), options.has_deltas),
        follower_(options.session, proto::SegmentKind::kScene),
        tool_(options.session, options.readers),
        scenes_(link_.participant().writer(stillgrid_relay3_Scene_desc, link_.topic("scene"),
                                           Delivery::kLasting)),
        snapshots_(link_.participant().writer(stillgrid_relay3_Snapshot_desc,
                                              link_.topic("snapshot"), Delivery::kNewest)),
        tools_(link_.participant().reader(stillgrid_relay3_Tool_desc, link_.topic("tool"),
                                          Delivery::kBestEffort)) {}

  void run(const std::atomic<bool>& stop) {
    link_.run(
        stop, [this](std::uint64_t now_ns) { wake(now_ns); },
        [this](std::uint64_t now_ns) { look(now_ns); });
    report_.keyframes = encoder_.keyframes();
    report_.deltas = encoder_.deltas();
  }

 private:
  void wake(std::uint64_t now_ns) {
    if (link_.hear(now_ns))
      encoder_.acknowledge(link_.other().status().scene_epoch, link_.other().status().keyframe_id);
    take_tool(now_ns);
  }

  void look(std::uint64_t now_ns) {
    look_at_scene(now_ns);
    repeat_scene(now_ns);
    link_.say(now_ns, {.segment_epoch = scene_epoch_});
    look_at_tool(now_ns);
  }

  void look_at_scene(std::uint64_t now_ns) {
    if (now_ns >= next_look_ns_) {
      next_look_ns_ = now_ns + 10'000'000;
      follower_.look();
      if (const std::string& refusal = follower_.refusal(); refusal != last_refusal_) {
        last_refusal_ = refusal;
        if (!refusal.empty()) spdlog::warn(refusal);
      }
      take_up_scene();
    }
    if (scene_epoch_ != 0 && now_ns >= next_snapshot_ns_ && !is_on_its_way(now_ns))
      tell_snapshot(*follower_.scene(), now_ns);
  }

  void take_up_scene() {
    const publication::SceneView* view = follower_.scene();
    const bool is_alive = follower_.life() == reading::Life::kAlive && view != nullptr;
    if (is_alive && view->header().clock != proto::Clock::kMonotonic) {
      if (refused_epoch_ != view->header().epoch)
        spdlog::warn(publication::clock_refusal(options_.session, proto::SegmentKind::kScene,
                                                proto::Clock::kMonotonic));
      refused_epoch_ = view->header().epoch;
      scene_epoch_ = 0;
      return;
    }
    const std::uint64_t epoch = is_alive ? view->header().epoch : 0;
    if (epoch == scene_epoch_) return;
    scene_epoch_ = epoch;
    if (epoch == 0) return;
    reader_.turn_to(*view);
    tell_scene(*view, realtime::monotonic_ns());
  }

  void tell_scene(const publication::SceneView& view, std::uint64_t now_ns) {
    next_scene_ns_ = now_ns + 2'000'000'000;
    const ToldScene scene(view, link_.relay_id(), least_period_ns());
    has_model_ = scene.message().state_capacity > 0;
    if (dds_write(scenes_, &scene.message()) != DDS_RETCODE_OK)
      spdlog::error("the scene could not be sent");
  }

  /// Once more to who says that it has none: it refused what came, or lost it.
  void repeat_scene(std::uint64_t now_ns) {
    const bool is_missed = scene_epoch_ != 0 && link_.other().is_connected() &&
                           link_.other().status().follows == link_.relay_id() &&
                           link_.other().status().scene_epoch != scene_epoch_;
    if (is_missed && now_ns >= next_scene_ns_) tell_scene(*follower_.scene(), now_ns);
  }

  /// A snapshot of many packets is not replaced by the next while what it lost is asked for: where
  /// that takes longer than a step, none would ever come whole. Not so of steps so fast that one of
  /// the next comes whole earlier.
  [[nodiscard]] bool is_on_its_way(std::uint64_t now_ns) const {
    const std::uint64_t patience_ns =
        std::min(kLongestWay_ns, kAnswer_ns + 4 * link_.clock().round_trip_ns());
    return sent_bytes_ * step_ns() > kFewPackets_bytes * kFewOfStep_ns &&
           link_.other().status().received < sent_number_ && now_ns < sent_ns_ + patience_ns;
  }

  /// From one snapshot that is sent to the next; no longer than kFewOfStep_ns.
  [[nodiscard]] std::uint64_t step_ns() const {
    return std::min(kFewOfStep_ns,
                    std::max(follower_.scene()->header().period_ns, least_period_ns()));
  }
  [[nodiscard]] std::uint64_t least_period_ns() const {
    return options_.rate_hz ? realtime::to_ns(1.0 / *options_.rate_hz) : 0;
  }

  void tell_snapshot(const publication::SceneView& view, std::uint64_t now_ns) {
    // A look copies all spheres.
    const std::uint64_t latest = double_buffer::HardwareAtomics::load(view.reader().live().latest,
                                                                      std::memory_order_relaxed);
    const std::uint64_t before = reader_.snapshot().snapshot_id;
    if (latest == before) return;
    const auto status = reading::look(
        reader_, view, kMaxSpheres,
        has_model_ ? reading::SnapshotDetail::kState : reading::SnapshotDetail::kSpheres,
        snapshot_);
    if (status != double_buffer::ReadStatus::kAccepted || snapshot_.snapshot_id == before) return;
    const SnapshotMessage& message = encoder_.encode(with_state(snapshot_, tool_), scene_epoch_);
    if (dds_write(snapshots_, &message) != DDS_RETCODE_OK) return;
    next_snapshot_ns_ = now_ns + least_period_ns();
    sent_ns_ = now_ns;
    sent_number_ = message.number;
    sent_bytes_ = message_bytes(message);
    ++report_.sent;
    report_.sent_bytes += message_bytes(message);
  }

  void take_tool(std::uint64_t now_ns) {
    take_all<ToolMessage>(tools_, [&](const ToolMessage& message) {
      if (!link_.accept(message.relay_id, message.number, message_bytes(message), now_ns) ||
          !link_.came_in_time(message.time_ns, now_ns) || scene_epoch_ == 0)
        return;
      try {
        const ShownTool::Shown shown = tool_.show(message, link_.clock(), now_ns);
        if (shown == ShownTool::Shown::kRefused)
          link_.refuse("a tool sample is refused: a number out of range");
        if (shown == ShownTool::Shown::kTaken)
          link_.warn("session '" + options_.session +
                     "' has another writer of its tool on this machine");
      } catch (const publication::SegmentError& error) {
        link_.warn(error.what());
      }
    });
  }

  /// A status that a sample has overtaken does not know of it yet; both are of the hand's clock.
  void look_at_tool(std::uint64_t now_ns) {
    const Status& status = link_.other().status();
    tool_.look(now_ns, kLongestWay_ns);
    if (link_.other().is_connected() && status.segment_epoch == 0 &&
        status.sent_ns > tool_.newest_ns())
      tool_.withdraw();
    if (proto::SegmentHeader* const header = tool_.header()) {
      publication::store_relay_figures(*header, link_.figures());
      report_.age_ns.record(now_ns - std::min(now_ns, tool_.time_ns()));
    }
    report_.segments = tool_.segments();
  }

  const RelayOptions& options_;
  RelayReport& report_;
  RelayLink link_;
  SnapshotEncoder encoder_;
  reading::SegmentFollower follower_;
  publication::SnapshotReader reader_;
  reading::SceneSnapshot snapshot_;
  ShownTool tool_;
  dds_entity_t scenes_, snapshots_, tools_;
  bool has_model_ = false;  // that is told
  std::string last_refusal_;
  std::uint64_t scene_epoch_ = 0, refused_epoch_ = 0;
  std::uint64_t next_look_ns_ = 0, next_scene_ns_ = 0, next_snapshot_ns_ = 0;
  std::uint64_t sent_ns_ = 0, sent_number_ = 0, sent_bytes_ = 0;  // of the last snapshot
};

}  // namespace

void relay_beside_simulation(const RelayOptions& options, RelayReport& report,
                             const std::atomic<bool>& stop) {
  SimulationSide(options, report).run(stop);
}

}  // namespace stillgrid::scene_relay

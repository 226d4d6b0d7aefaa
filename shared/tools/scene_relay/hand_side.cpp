#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "shared/publication/relay_figures.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/deadband.hpp"
#include "shared/tools/scene_relay/relay.hpp"
#include "shared/tools/scene_relay/shown_scene.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"
#include "shared/tools/scene_relay/tool_messages.hpp"

namespace stillgrid::scene_relay {
namespace {

class HandSide {
 public:
  HandSide(const RelayOptions& options, RelayReport& report, const std::atomic<bool>& stop)
      : options_(options),
        report_(report),
        stop_(stop),
        lock_(std::in_place, options.session, proto::SegmentKind::kScene),
        link_(options, Role::kHand, report),
        tool_(link_.relay_id()),
        tools_(link_.participant().writer(stillgrid_relay3_Tool_desc, link_.topic("tool"),
                                          Delivery::kBestEffort)),
        scenes_(link_.participant().reader(stillgrid_relay3_Scene_desc, link_.topic("scene"),
                                           Delivery::kLasting, false)),
        snapshots_(link_.participant().reader(stillgrid_relay3_Snapshot_desc,
                                              link_.topic("snapshot"), Delivery::kNewest)) {
    if (options.deadband) deadband_.emplace(DeadbandLimits{.velocity_share = *options.deadband});
  }

  void run() {
    link_.run(
        stop_, [this](std::uint64_t now_ns) { wake(now_ns); },
        [this](std::uint64_t now_ns) { look(now_ns); });
  }

 private:
  void wake(std::uint64_t now_ns) {
    if (link_.hear(now_ns)) follow_scene();
    take_scene(now_ns);
    take_snapshots(now_ns);
    RelayLink::Said said{.received = received_};
    if (scene_) said = {tool_epoch(), scene_->epoch(), decoder_.keyframe_id(), received_};
    link_.say(now_ns, said);
  }

  void look(std::uint64_t now_ns) {
    if (scene_) {
      tell_tool();
      // However silent the network is: the segment's readers are told of that.
      publication::store_relay_figures(scene_->hand().writer().header(), link_.figures());
    }
    if (state_ns_ != 0) report_.age_ns.record(now_ns - std::min(now_ns, state_ns_));
  }

  /// A simulation that ended or was killed there ends here; so does one whose relay took another.
  /// A status that the scene has overtaken does not know of it yet, and one of another scene may be
  /// a flipped bit's: these count from the second on.
  void follow_scene() {
    const Status& status = link_.other().status();
    if (!scene_ || status.segment_epoch == scene_->epoch()) {
      denials_ = 0;
      return;
    }
    const bool is_told = newest_ns_ != 0 && newest_of_ == status.relay_id;
    if (is_told && status.sent_ns < newest_ns_) return;
    if (++denials_ >= 2 || (status.segment_epoch == 0 && is_told)) withdraw();
  }

  void withdraw() {
    scene_.reset();
    state_ns_ = newest_ns_ = denials_ = 0;
    decoder_.begin();
  }

  /// The one of the start; later, as it goes with each segment, another, unless it is taken.
  std::optional<publication::SessionLock> take_lock() {
    if (!lock_)
      return publication::SessionLock::try_take(options_.session, proto::SegmentKind::kScene);
    std::optional<publication::SessionLock> lock = std::move(lock_);
    lock_.reset();
    return lock;
  }

  void take_scene(std::uint64_t now_ns) {
    // Whose is it, and how far away? Until then it waits.
    if (link_.other().followed() == 0 || !link_.clock().is_known()) return;
    take_all<SceneMessage>(scenes_, [&](const SceneMessage& message) {
      if (!link_.other().is_followed(message.relay_id)) return;
      if (scene_ && scene_->epoch() == message.scene_epoch) return;
      withdraw();
      try {
        std::optional<publication::SessionLock> lock = take_lock();
        if (!lock)
          return link_.warn("session '" + options_.session +
                            "' has another writer of its scene on this machine");
        scene_.emplace(options_.session, std::move(*lock), message, options_.readers, now_ns,
                       link_.clock().round_trip_ns());
        ++report_.segments;
      } catch (const MessageError& error) {
        link_.refuse(error.what());
      } catch (const publication::SegmentError& error) {
        link_.warn(error.what());  // as one that is larger than this machine's memory
      }
    });
  }

  /// Of those that came since the last look the newest is shown: two at one instant would be a
  /// period of none.
  void take_snapshots(std::uint64_t now_ns) {
    bool is_due = false;
    take_all<SnapshotMessage>(snapshots_, [&](const SnapshotMessage& message) {
      if (!link_.accept(message.relay_id, message.number, message_bytes(message), now_ns)) return;
      received_ = message.number;
      if (!scene_ || scene_->epoch() != message.scene_epoch) return;
      try {
        const Decoded decoded = decoder_.decode(message, scene_->limits(), snapshot_);
        report_.without_keyframe += decoded == Decoded::kWithoutKeyframe ? 1 : 0;
        if (decoded != Decoded::kSnapshot) return;
      } catch (const MessageError& error) {
        return link_.refuse(error.what());
      }
      // A simulation that does not hear the hand has no tool: what it shows gives way to nobody.
      if (!link_.other().is_hearing()) return;
      // What is older than that was too long on its way.
      const bool is_recent = newest_ns_ != 0 && now_ns < shown_ns_ + kLongestWay_ns;
      if (is_recent && snapshot_.snapshot_id <= snapshot_id_) return;
      if (is_due && snapshot_.snapshot_id <= due_.snapshot_id) return;
      if (!link_.came_in_time(snapshot_.publish_time_ns, now_ns)) return;
      std::swap(due_, snapshot_);
      is_due = true;
    });
    if (is_due) show(due_, now_ns);
  }

  void show(const ToldSnapshot& snapshot, std::uint64_t now_ns) {
    snapshot_id_ = snapshot.snapshot_id;
    newest_ns_ = snapshot.publish_time_ns;
    newest_of_ = link_.other().followed();
    shown_ns_ = now_ns;
    // Later than the last, whatever was learnt of the clock since; and never of the future.
    const std::uint64_t here_ns = link_.clock().to_ours(snapshot.state_time_ns);
    state_ns_ = std::max(std::min(here_ns, now_ns), state_ns_ + 1);
    scene_->show(snapshot, {.state_ns = state_ns_,
                            .publish_ns = now_ns,
                            .tool_ns = snapshot.tool_time_ns,
                            .step_ns = snapshot.step_ns,
                            .contacts = snapshot.contacts,
                            .tool_work_J = snapshot.tool_work_J});
  }

  std::uint64_t tool_epoch() {
    const publication::ToolView* view = scene_->hand().tool().acquire();
    return view != nullptr && scene_->hand().tool().writer_alive() ? view->header().epoch : 0;
  }

  void tell_tool() {
    const std::uint64_t epoch = tool_epoch();
    const auto state = scene_->hand().take_tool();
    if (epoch == 0 || !state || (epoch == tool_epoch_ && state->tick == tool_tick_)) return;
    if (deadband_ && epoch != tool_epoch_) deadband_->begin_anew();
    tool_epoch_ = epoch;
    tool_tick_ = state->tick;
    // Along a path with gaps the local copy would come to other states than the simulation.
    const bool has_path = scene_->has_model();
    if (!has_path && deadband_ && !deadband_->must_send(*state)) {
      ++report_.withheld;
      return;
    }
    ToolMessage message = tool_.encode(*scene_->hand().tool().acquire(), *state, has_path);
    message.is_led_on = !has_path && deadband_.has_value();
    if (dds_write(tools_, &message) != DDS_RETCODE_OK) return;
    ++report_.sent;
    report_.sent_bytes += message_bytes(message);
  }

  const RelayOptions& options_;
  RelayReport& report_;
  const std::atomic<bool>& stop_;
  std::optional<publication::SessionLock> lock_;  // until a scene has it
  RelayLink link_;
  ToolMessages tool_;
  SnapshotDecoder decoder_;
  ToldSnapshot snapshot_, due_;
  dds_entity_t tools_, scenes_, snapshots_;
  std::optional<ShownScene> scene_;
  std::optional<Deadband> deadband_;
  std::uint64_t snapshot_id_ = 0, state_ns_ = 0, shown_ns_ = 0, received_ = 0, tool_epoch_ = 0,
                tool_tick_ = 0;
  // Of the last snapshot that was shown, on the simulation's clock, and its relay; 0: none was.
  std::uint64_t newest_ns_ = 0, newest_of_ = 0;
  std::uint64_t denials_ = 0;  // statuses one after the other that know of no such scene
};

}  // namespace

void relay_beside_hand(const RelayOptions& options, RelayReport& report,
                       const std::atomic<bool>& stop) {
  HandSide(options, report, stop).run();
}

}  // namespace stillgrid::scene_relay

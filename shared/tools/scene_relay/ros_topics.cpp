#include "shared/tools/scene_relay/ros_topics.hpp"

#include <spdlog/spdlog.h>

#include <string>

#include "shared/publication/hands.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/ros_messages.hpp"
#include "shared/tools/scene_relay/ros_names.hpp"
#include "shared/tools/scene_relay/ros_writer.hpp"

namespace stillgrid::scene_relay {
namespace {

/// Not half a millisecond: beside a loop of 1 kHz the looks would keep their distance to its ticks,
/// and those that are a little late at times would miss many.
constexpr std::uint64_t kLook_ns = 400'000;
constexpr std::uint64_t kLooksPerFollow = 25;  // 10 ms

/// Why what stands under the session's name is not published, one line; empty where it is.
std::string complaint_of(const reading::SegmentFollower& tool) {
  if (!tool.refusal().empty()) return tool.refusal();
  const bool is_virtual =
      tool.life() == reading::Life::kAlive && tool.tool()->header().clock == proto::Clock::kVirtual;
  return is_virtual
             ? "the haptic_server runs in lockstep: its time is none of ROS's, nothing of it "
               "is published"
             : "";
}

/// The tool's segment, followed while its writers come and go, each complaint of it logged once.
class FollowedTool {
 public:
  explicit FollowedTool(const std::string& session)
      : follower_(session, proto::SegmentKind::kTool) {}

  void look() {
    follower_.look();
    const std::string complaint = complaint_of(follower_);
    if (!complaint.empty() && complaint != last_complaint_) spdlog::warn("{}", complaint);
    last_complaint_ = complaint;
    is_heard_ = complaint.empty() && follower_.life() == reading::Life::kAlive;
  }

  /// The segment of a writer that lived when it was looked at last, or null.
  [[nodiscard]] const publication::ToolView* view() const noexcept {
    return is_heard_ ? follower_.tool() : nullptr;
  }

 private:
  reading::SegmentFollower follower_;
  std::string last_complaint_;
  bool is_heard_ = false;
};

void log_figures(const RosFigures& figures) {
  const RosCounts& counts = figures.counts;
  spdlog::info(
      "{} poses and forces published; of the tool's states {} were spared by --rate, {} missed, "
      "{} refused, {} not sent",
      figures.published, counts.spared, counts.missed, counts.refused, figures.unsent);
}

}  // namespace

RosFigures run_ros_topics(dds_entity_t participant, const RosOptions& options,
                          const std::atomic<bool>& stop) {
  const RosNames names = ros_names(options.session);
  publication::require_hand(options.session);
  const RosWriter poses(participant, names.pose_topic, geometry_msgs_msg_dds__PoseStamped__desc,
                        kPoseTypeHash);
  const RosWriter wrenches(participant, names.wrench_topic,
                           geometry_msgs_msg_dds__WrenchStamped__desc, kWrenchTypeHash);
  spdlog::info("{} and {}, frame {}", names.pose_topic, names.wrench_topic, names.frame);

  FollowedTool tool(options.session);
  RosSource source(options.rate_hz);
  RosFigures figures;
  realtime::PeriodicTimer timer(kLook_ns);
  for (std::uint64_t looks = 0; !stop; ++looks, timer.wait(&stop)) {
    if (looks % kLooksPerFollow == 0) tool.look();
    if (tool.view() == nullptr) continue;
    const auto state = tool.view()->read();
    if (!state || !source.takes(tool.view()->header(), *state, realtime::monotonic_ns())) continue;
    const auto stamp = ros_stamp(state->time_ns, read_clocks());
    const RosPose pose = pose_message(*state, stamp.value_or(RosStamp{}), names.frame);
    const RosWrench wrench = wrench_message(*state, stamp.value_or(RosStamp{}), names.frame);
    const bool is_sent = stamp && poses.write(&pose) && wrenches.write(&wrench);
    ++(is_sent ? figures.published : figures.unsent);
  }
  figures.counts = source.counts();
  log_figures(figures);
  return figures;
}

}  // namespace stillgrid::scene_relay

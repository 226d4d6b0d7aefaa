#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_relay/other_side.hpp"
#include "shared/tools/scene_relay/sequence.hpp"
#include "shared/tools/scene_relay/shown_scene.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"
#include "tests/fuzz/checked_ticks.hpp"
#include "tests/fuzz/hostile_object.hpp"
#include "tests/fuzz/patch.hpp"
#include "tests/fuzz/valid_segment.hpp"
#include "tests/fuzz/wire_message.hpp"

/// What a relay beside the hand makes of messages, whatever bytes a network brings: what is shown
/// of them is a scene whose force keeps its laws, or they are refused in a line.
///
/// Input: for each of at most six messages a kind u8 (bits 0 to 2: one of `valid`; 8: the rest of
/// the input stands in its place), patches, then what CheckedTicks takes where a snapshot is shown.
namespace stillgrid::fuzz {
namespace {

using scene_relay::SceneMessage;
using scene_relay::SnapshotMessage;
using scene_relay::Status;

enum Kind : std::size_t { kStatus, kGreeting, kScene, kTool, kKeyframe, kDelta, kLast, kWhole };
constexpr unsigned kRaw = 8;
constexpr int kMaxMessages = 6;
constexpr std::uint64_t kRelay = 7, kOwnRelay = 8;
constexpr std::uint32_t kMaxShown = 4096;  // moving spheres: more take long, and nothing else

struct WireTypes {
  WireType status{stillgrid_relay3_Status_desc};
  WireType greeting{stillgrid_Greeting_desc};
  WireType scene{stillgrid_relay3_Scene_desc};
  WireType tool{stillgrid_relay3_Tool_desc};
  WireType snapshot{stillgrid_relay3_Snapshot_desc};
};

/// What a relay beside the simulation of the valid segment tells, a message a kind.
class ValidMessages {
 public:
  ValidMessages() {
    const std::vector<std::byte> segment = valid_scene();
    const HostileObject object(proto::SegmentKind::kScene, segment);
    const publication::SceneView view(*publication::SegmentReader::open(
        HostileObject::session(), proto::SegmentKind::kScene, proto::kSceneLayoutHash));
    const scene_relay::ToldScene scene(view, kRelay);
    bytes_[kScene] = types.scene.bytes_of(&scene.message());
    const auto snapshot = reading::read_snapshot(view, scene_relay::kMaxSpheres);
    require(snapshot.has_value(), "the valid segment has a snapshot");
    tell(scene_relay::told(*snapshot, 0), scene.message().scene_epoch);
    const Status status{.relay_id = kRelay,
                        .number = 3,
                        .sent_ns = 91'000'000,
                        .echo_sent_ns = 80'000'000,
                        .echo_received_ns = 90'500'000,
                        .received = 0,
                        .follows = kOwnRelay,
                        .segment_epoch = 1,
                        .scene_epoch = 1,
                        .keyframe_id = 0};
    bytes_[kStatus] = types.status.bytes_of(&status);
    scene_relay::Greeting greeting{};
    greeting.relay_id = kRelay + 2;
    greeting.protocol = scene_relay::kProtocol + 1;
    greeting.role = static_cast<std::uint32_t>(scene_relay::Role::kSimulation);
    std::strcpy(greeting.release, "9.9");
    bytes_[kGreeting] = types.greeting.bytes_of(&greeting);
    scene_relay::ToolMessage tool{};
    tool.relay_id = kRelay;
    tool.number = 1;
    tool.orientation_xyzw[3] = 1.0;
    bytes_[kTool] = types.tool.bytes_of(&tool);
  }

  [[nodiscard]] const std::vector<std::byte>& operator[](Kind kind) const { return bytes_[kind]; }

  WireTypes types;

 private:
  /// A keyframe, a delta to it of two spheres, one of all, and one that is told whole.
  void tell(const scene_relay::ToldSnapshot& snapshot, std::uint64_t epoch) {
    scene_relay::SnapshotEncoder encoder(kRelay);
    SnapshotMessage message = encoder.encode(snapshot, epoch);
    bytes_[kWhole] = types.snapshot.bytes_of(&message);
    message.is_keyframe = true;
    bytes_[kKeyframe] = types.snapshot.bytes_of(&message);
    message.is_keyframe = false;
    message.against_id = message.snapshot_id;
    message.snapshot_id += 2;
    bytes_[kLast] = types.snapshot.bytes_of(&message);
    --message.snapshot_id;
    std::vector<std::uint32_t> moved{1, 5}, none;
    std::vector<scene_relay::Motion> motions{snapshot.motions[5], snapshot.motions[1]};
    std::vector<scene_relay::Label> labels;
    scene_relay::point_to(message.moved, moved);
    scene_relay::point_to(message.motions, motions);
    scene_relay::point_to(message.labels, labels);
    bytes_[kDelta] = types.snapshot.bytes_of(&message);
  }

  std::array<std::vector<std::byte>, 8> bytes_;
};

void require_line(const std::string& line) {
  require(!line.empty() && line.size() < 300, "what is said is a line");
  require(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }),
          "of a terminal's letters");
}

/// The relay's parts beside the hand, as it joins them.
class HandParts {
 public:
  HandParts(const ValidMessages& valid, FuzzInput& input) : valid_(valid), input_(input) {}

  void take(Kind kind, const std::vector<std::byte>& bytes) {
    const WireTypes& types = valid_.types;
    now_ns_ += 10'000'000;
    switch (kind) {
      case kStatus:
        return types.status.read<Status>(bytes, [&](const Status& status) { hear(status); });
      case kGreeting:
        return types.greeting.read<scene_relay::Greeting>(
            bytes, [&](const auto& greeting) { other_.hear(greeting); });
      case kTool:  // a simulation's relay takes it, which asks publication::is_sound()
        return types.tool.read<scene_relay::ToolMessage>(bytes, [](const auto&) {});
      case kScene:
        return types.scene.read<SceneMessage>(bytes, [&](const auto& scene) { begin(scene); });
      default:
        if (!scene_) take(kScene, valid_[kScene]);
        return types.snapshot.read<SnapshotMessage>(bytes,
                                                    [&](const auto& snapshot) { show(snapshot); });
    }
  }

  /// Snapshots so far.
  [[nodiscard]] int shown() const noexcept { return shown_; }

 private:
  void hear(const Status& status) {
    other_.hear(status, now_ns_);
    other_.look(now_ns_);
    const scene_relay::ClockOffset& clock = other_.clock();
    static_cast<void>(other_.next_status(now_ns_));
    for (const std::uint64_t time_ns : {std::uint64_t{0}, now_ns_, status.sent_ns}) {
      static_cast<void>(clock.to_ours(time_ns));
      static_cast<void>(clock.to_others(time_ns));
    }
  }

  void begin(const SceneMessage& message) {
    scene_.reset();
    view_.reset();
    decoder_.begin();
    try {
      const publication::StaticScene scene = scene_relay::scene_of(message);
      if (message.moving_capacity > kMaxShown) return;
      const std::string session = HostileObject::session();
      scene_.emplace(session, publication::SessionLock(session, proto::SegmentKind::kScene),
                     message, std::nullopt, now_ns_);
      view_.emplace(*publication::SegmentReader::open(session, proto::SegmentKind::kScene,
                                                      proto::kSceneLayoutHash));
    } catch (const scene_relay::MessageError& error) {
      require_line(error.what());
    }
  }

  void show(const SnapshotMessage& message) {
    if (!scene_) return;
    scene_relay::ToldSnapshot snapshot;
    try {
      if (decoder_.decode(message, scene_->limits(), snapshot) ==
          scene_relay::Decoded::kWithoutKeyframe)
        return;
    } catch (const scene_relay::MessageError& error) {
      return require_line(error.what());
    }
    scene_relay::check(snapshot, scene_->limits());  // throws where what is decoded is unsound
    scene_->show(snapshot, {.state_ns = now_ns_ - 3'000'000,
                            .publish_ns = now_ns_,
                            .tool_ns = snapshot.tool_time_ns,
                            .step_ns = snapshot.step_ns,
                            .contacts = snapshot.contacts,
                            .tool_work_J = snapshot.tool_work_J});
    ticks_.tick(*view_, input_);
    ++shown_;
  }

  const ValidMessages& valid_;
  FuzzInput& input_;
  std::uint64_t now_ns_ = 90'000'000;
  int shown_ = 0;
  scene_relay::OtherSide other_{kOwnRelay, scene_relay::Role::kHand, "fuzz", require_line};
  scene_relay::SnapshotDecoder decoder_;
  std::optional<scene_relay::ShownScene> scene_;
  std::optional<publication::SceneView> view_;
  CheckedTicks ticks_;
};

/// Else inputs would be changes of nothing.
void require_shown(const ValidMessages& valid) {
  FuzzInput none({});
  const auto hand = std::make_unique<HandParts>(valid, none);
  for (const Kind kind : {kScene, kKeyframe, kDelta, kLast, kWhole}) hand->take(kind, valid[kind]);
  require(hand->shown() == 4, "the valid messages are shown");
}

std::vector<std::byte> spoilt(std::vector<std::byte> bytes, bool is_raw, FuzzInput& input) {
  const std::array<std::span<std::byte>, 1> regions{bytes};
  apply_patches(regions, input);
  if (!is_raw) return bytes;
  const auto rest = std::as_bytes(input.take_rest());
  return {rest.begin(), rest.end()};
}

}  // namespace
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ValidMessages valid;
  [[maybe_unused]] static const bool are_shown = (require_shown(valid), true);
  FuzzInput input({data, size});
  const auto hand = std::make_unique<HandParts>(valid, input);
  for (int i = 0; i < kMaxMessages && (i == 0 || !input.is_empty()); ++i) {
    const unsigned flags = input.take<std::uint8_t>();
    const auto kind = static_cast<Kind>(flags % 8);
    hand->take(kind, spoilt(valid[kind], (flags & kRaw) != 0, input));
  }
  return 0;
}

}  // namespace stillgrid::fuzz

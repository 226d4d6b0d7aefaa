#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "shared/dynamics/scene_ticks.hpp"
#include "shared/dynamics/tool_path.hpp"
#include "shared/publication/moving_records.hpp"
#include "shared/rendering/local_renderer.hpp"
#include "shared/tools/scene_relay/sequence.hpp"
#include "shared/tools/scene_relay/shown_scene.hpp"
#include "shared/tools/scene_relay/shown_tool.hpp"
#include "shared/tools/scene_relay/snapshot_coding.hpp"
#include "shared/tools/scene_relay/told_scene.hpp"
#include "shared/tools/scene_relay/tool_messages.hpp"
#include "tests/network/relay/generated_snapshots.hpp"
#include "tests/network/relay/relayed_scene.hpp"
#include "tests/shared/dynamics/engine_scenes.hpp"
#include "tests/shared/publication/test_session.hpp"

/// A session over a relay in virtual time, in ticks of 1 ms: the relays' own parts between the
/// servers' own parts, without DDS.
namespace stillgrid::scene_relay {

inline constexpr std::uint64_t kMs_ns = 1'000'000;

/// A ball of 20 mm on a floor, and a tool of 10 mm.
inline dynamics::SceneModel ball_model() {
  dynamics::EngineScene scene;
  scene.with_gravity();
  scene.add_plane(Eigen::Vector3d::UnitZ(), 0.0);
  scene.add_ball(0.02, {0.0, 0.0, 0.021});
  const int tool = scene.add_rigid(0.0, Eigen::Vector3d::Zero(), {0.0, 0.0, 1.0}, true);
  scene.add_sphere(tool, 0.01);
  dynamics::SceneModel model;
  model.description = scene.description;
  model.start = scene.state;
  model.start.is_here = {1, 0};
  model.hands = 1;
  return model;
}

inline publication::StaticScene published_ball(const dynamics::SceneModel& model) {
  publication::StaticScene scene;
  scene.name = "ball";
  scene.materials = {{1000.0F, 2.0F, 0.5F, 1e-3F}};
  scene.planes = {{{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0}};
  scene.tool = {{{0.0F, 0.0F, 0.0F}, 0.01F}};
  scene.device = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}, 1.0};
  scene.model = dynamics::encode(model);
  scene.state_capacity = 32'768;
  scene.hands = {""};
  return scene;
}

/// Presses the ball and rolls it.
inline proto::ToolState hand_at(std::uint64_t tick) {
  const double t_s = 1e-3 * static_cast<double>(tick);
  proto::ToolState state{};
  state.position_m = {0.004 * std::sin(9.0 * t_s), 0.003 * std::sin(7.0 * t_s),
                      0.0485 - 0.0012 * std::sin(23.0 * t_s)};
  state.velocity_m_s = {0.036 * std::cos(9.0 * t_s), 0.021 * std::cos(7.0 * t_s),
                        -0.0276 * std::cos(23.0 * t_s)};
  state.orientation_xyzw = {0.0, 0.0, std::sin(0.3 * t_s), std::cos(0.3 * t_s)};
  return state;
}

/// The simulation: it steps along its tool's path, as sim_server does, and publishes the state.
class PathSimulation {
 public:
  PathSimulation(const std::string& session, std::uint64_t period_ticks)
      : session_(session),
        ticks_(ball_model()),
        records_(1),
        writer_(session, published_ball(ball_model()), 1, period_ticks * kMs_ns,
                proto::Clock::kMonotonic, 0) {}

  /// Steps as far as `now` and the path, and publishes.
  void step(std::uint64_t now) {
    follow();
    const auto newest = path_.newest();
    if (!newest) return;
    if (!has_begun_) number_ = *path_.oldest() - 1;
    has_begun_ = true;
    for (const std::uint64_t end = std::min(*newest, now); number_ < end;) {
      const std::optional<dynamics::ToolPose> pose = path_.pose_at(number_ + 1);
      ticks_.step({.tools = {&pose, 1}});
      states_[++number_] = dynamics::hash(ticks_.engine().state());
    }
    publish(now);
  }

  /// Hashes of all states by their number.
  [[nodiscard]] const std::map<std::uint64_t, std::uint64_t>& states() const { return states_; }

 private:
  void follow() {
    auto reader = publication::SegmentReader::open(session_, proto::SegmentKind::kTool,
                                                   proto::kToolLayoutHash);
    if (!reader) return;
    const publication::ToolView tool(std::move(*reader));
    if (tool.header().epoch != epoch_) path_ = {};
    epoch_ = tool.header().epoch;
    dynamics::follow(tool.path(), path_);
  }

  void publish(std::uint64_t now) {
    const dynamics::SceneState& state = ticks_.engine().state();
    const Eigen::Vector3d place_m = state.rigid_position_m[0].vector();
    const Eigen::Vector3d velocity_m_s = state.rigid_velocity_m_s[0].vector();
    const double radius_m = 0.02;
    records_.declare({.struct_size = sizeof(stillgrid_shapes),
                      .count = 1,
                      .radii_m = &radius_m,
                      .materials = nullptr,
                      .bodies = nullptr,
                      .positions_m = nullptr});
    records_.place(place_m.data(), velocity_m_s.data(), 0.01);
    std::vector<std::byte> block;
    ticks_.save(block);
    writer_.publish(
        records_.grid(),
        {.state_ns = number_ * kMs_ns, .publish_ns = now * kMs_ns, .tool_ns = number_ * kMs_ns}, {},
        {.bytes = block, .tick = number_, .hash = dynamics::hash(state)});
  }

  std::string session_;
  dynamics::SceneTicks ticks_;
  dynamics::TickPath path_;
  publication::MovingRecords records_;
  publication::SceneWriter writer_;
  std::map<std::uint64_t, std::uint64_t> states_;
  std::uint64_t number_ = 0, epoch_ = 0;
  bool has_begun_ = false;
};

/// A rendered tick of the hand.
struct FeltTick {
  rendering::RenderedTick tick;
  std::uint64_t state = 0;  // hash of the local copy's
  [[nodiscard]] bool is_same_force(const FeltTick& other) const {
    return tick.force.force_N == other.tick.force.force_N &&
           tick.force.torque_N_m == other.tick.force.torque_N_m;
  }
};

/// The hand: it publishes its tool, and renders as haptic_server --transition local.
class PathHand {
 public:
  explicit PathHand(const std::string& session)
      : session_(session), writer_(session, kMs_ns, proto::Clock::kMonotonic, 0) {}

  void move_to(std::uint64_t tick) {
    state_ = hand_at(tick);
    state_.time_ns = tick * kMs_ns;
    state_.path_number = state_.tick = tick;
    writer_.publish(state_);
  }

  /// Pre: move_to(tick).
  [[nodiscard]] FeltTick render(std::uint64_t tick) {
    look_at_scene();
    if (!view_) return {};
    const rendering::ToolPose pose{
        .position_m = Eigen::Vector3d(state_.position_m.data()),
        .orientation = Eigen::Quaterniond(state_.orientation_xyzw.data()),
        .velocity_m_s = Eigen::Vector3d(state_.velocity_m_s.data())};
    FeltTick felt{renderer_.render(*view_, pose, tick * kMs_ns, {}, copy_.get())};
    if (felt.tick.is_local)
      felt.state = dynamics::hash(std::get<local::LocalScene>(copy_->scene()).state());
    return felt;
  }

 private:
  void look_at_scene() {
    auto reader = publication::SegmentReader::open(session_, proto::SegmentKind::kScene,
                                                   proto::kSceneLayoutHash);
    if (!reader || (view_ && view_->header().epoch == reader->header().epoch)) return;
    view_ = std::make_unique<publication::SceneView>(std::move(*reader));
    copy_ = std::make_unique<rendering::LocalCopy>(*view_);
  }

  std::string session_;
  publication::ToolWriter writer_;
  proto::ToolState state_{};
  std::unique_ptr<publication::SceneView> view_;
  std::unique_ptr<rendering::LocalCopy> copy_;
  rendering::LocalRenderer renderer_;
};

/// A tool's message that lives by itself.
class KeptTool {
 public:
  explicit KeptTool(const ToolMessage& message) : message_(message) {
    const auto path = elements(message.path);
    path_.assign(path.begin(), path.end());
  }
  [[nodiscard]] const ToolMessage& message() {
    point_to(message_.path, path_);
    return message_;
  }

 private:
  ToolMessage message_;
  std::vector<PathSample> path_;
};

/// A link between two machines.
struct RelayedLink {
  std::uint64_t delay = 0,
                jitter = 0;  // ticks: one way takes delay to delay + jitter, in any order
  double loss = 0.0;         // share of tool samples, and of snapshots
};

/// Both relays' parts. Clocks: that of the simulation's machine is the hand's plus offset_ns, and
/// gains drift. Thread: one.
class RelayParts {
 public:
  RelayParts(std::string simulation, std::string hand, const RelayedLink& link,
             std::int64_t offset_ns, double drift, std::uint32_t seed)
      : simulation_(std::move(simulation)),
        hand_(std::move(hand)),
        link_(link),
        offset_ns_(offset_ns),
        drift_(drift),
        random_(seed) {
    restart_simulation_side();
    restart_hand_side();
  }

  void restart_simulation_side() {
    tool_ = std::make_unique<ShownTool>(simulation_, std::nullopt);
    encoder_ = std::make_unique<SnapshotEncoder>(++relay_);
    reader_ = {};
    scene_ = std::make_unique<ToldScene>(view_of(simulation_), relay_);
  }
  void restart_hand_side() {
    shown_.reset();
    shown_ = std::make_unique<ShownScene>(
        hand_, publication::SessionLock(hand_, proto::SegmentKind::kScene), scene_->message(),
        std::nullopt, 1);
    decoder_ = {};
    tool_messages_ = std::make_unique<ToolMessages>(++hand_relay_);
    tool_number_ = 0;
  }
  void cut(bool is_cut) { is_cut_ = is_cut; }

  [[nodiscard]] std::uint64_t simulation_ns(std::uint64_t tick) const {
    const auto gained_ns = static_cast<std::int64_t>(drift_ * 1e6 * static_cast<double>(tick));
    return tick * kMs_ns + static_cast<std::uint64_t>(offset_ns_ + gained_ns);
  }
  [[nodiscard]] const ShownTool& tool() const noexcept { return *tool_; }

  /// Sends the tool in this tick of the hand, and shows the messages that have arrived.
  void carry_tool(std::uint64_t tick) {
    learn_clock(tick);
    const publication::ToolView view(publication::SegmentReader::require(
        hand_, proto::SegmentKind::kTool, proto::kToolLayoutHash));
    const ToolMessage& message =
        tool_messages_->encode(view, view.read().value(), shown_->has_model());
    if (!is_lost()) tools_.emplace_back(tick + delay(), KeptTool(message));
    receive(tools_, tick, [&](KeptTool& kept) {
      // RelayLink::accept() does the same.
      if (kept.message().relay_id != hand_relay_ || kept.message().number <= tool_number_) return;
      tool_number_ = kept.message().number;
      if (tool_->show(kept.message(), clock_, simulation_ns(tick)) == ShownTool::Shown::kRefused)
        ++refused;
    });
  }

  /// Sends the newest snapshot, and shows those that have arrived.
  void carry_snapshots(std::uint64_t tick) {
    const publication::SceneView view = view_of(simulation_);
    const std::uint64_t before = reader_.snapshot().snapshot_id;
    reader_.turn_to(view);
    const auto status =
        reading::look(reader_, view, kMaxSpheres, reading::SnapshotDetail::kState, snapshot_);
    if (status == double_buffer::ReadStatus::kAccepted && snapshot_.snapshot_id != before) {
      const SnapshotMessage& message = encoder_->encode(with_state(snapshot_, *tool_), 1);
      if (!is_lost())
        snapshots_.emplace_back(tick + delay(), std::make_unique<KeptMessage>(message));
    }
    receive(snapshots_, tick, [&](std::unique_ptr<KeptMessage>& kept) {
      ToldSnapshot came;
      const SnapshotMessage& message = kept->message();
      if (message.snapshot_id <= shown_id_) return;
      shown_id_ = message.snapshot_id;
      if (decoder_.decode(message, shown_->limits(), came) != Decoded::kSnapshot) return;
      tool_times.push_back(came.tool_time_ns);
      shown_->show(came, {.state_ns = tick * kMs_ns - 1, .publish_ns = tick * kMs_ns});
    });
  }

  std::size_t refused = 0;
  std::vector<std::uint64_t> tool_times;  // the snapshots', on the hand's clock

 private:
  bool is_lost() { return is_cut_ || std::bernoulli_distribution(link_.loss)(random_); }
  std::uint64_t delay() { return link_.delay + random_() % (link_.jitter + 1); }

  template <class Due, class Use>
  static void receive(std::vector<Due>& in_flight, std::uint64_t tick, const Use& use) {
    const auto due = std::stable_partition(in_flight.begin(), in_flight.end(),
                                           [&](const Due& one) { return one.first > tick; });
    for (auto one = due; one != in_flight.end(); ++one) use(one->second);
    in_flight.erase(due, in_flight.end());
  }

  /// An exchange each tenth of a second; the first three before all else.
  void learn_clock(std::uint64_t tick) {
    const std::uint64_t trip = 2 * link_.delay;
    for (std::uint64_t n = clock_.is_known() ? 0 : 3; n > 0; --n) exchange(tick - 1000 * n, trip);
    if (tick % 100 == 0) exchange(tick, trip);
  }
  void exchange(std::uint64_t tick, std::uint64_t trip) {
    const std::uint64_t there_ns = (tick - trip / 2) * kMs_ns;
    static_cast<void>(
        clock_.add({simulation_ns(tick - trip), there_ns, there_ns, simulation_ns(tick)}));
  }

  std::string simulation_, hand_;
  RelayedLink link_;
  std::int64_t offset_ns_;
  double drift_;
  std::mt19937 random_;
  ClockOffset clock_;
  std::unique_ptr<ToldScene> scene_;
  std::unique_ptr<ShownTool> tool_;
  std::unique_ptr<SnapshotEncoder> encoder_;
  SnapshotDecoder decoder_;
  publication::SnapshotReader reader_;
  reading::SceneSnapshot snapshot_;
  std::unique_ptr<ShownScene> shown_;
  std::unique_ptr<ToolMessages> tool_messages_;
  std::vector<std::pair<std::uint64_t, KeptTool>> tools_;
  std::vector<std::pair<std::uint64_t, std::unique_ptr<KeptMessage>>> snapshots_;
  std::uint64_t relay_ = 0, hand_relay_ = 0, tool_number_ = 0, shown_id_ = 0;
  bool is_cut_ = false;
};

}  // namespace stillgrid::scene_relay

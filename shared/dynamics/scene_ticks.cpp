#include "shared/dynamics/scene_ticks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/rigid_motion.hpp"

namespace stillgrid::dynamics {

SceneTicks::SceneTicks(SceneModel model, double time_s, EngineMethod method)
    : prescribed_(std::move(model.prescribed)),
      hands_(model.hands),
      counts_(counts_of(model.description)),
      time_s_(time_s),
      engine_(
          std::make_unique<Engine>(std::move(model.description), std::move(model.start), method)) {
  const Description& description = engine_->description();
  for (std::size_t r = 0; r < description.rigid_bodies.size(); ++r)
    if (description.rigid_bodies[r].is_driven)
      driven_.emplace_back().orientation = engine_->state().orientation[r].quaternion();
}

/// Where driven bodies are at the end of the tick.
void SceneTicks::aim(const Tick& tick) {
  const SceneState& state = engine_->state();
  for (std::size_t k = 0; k < prescribed_.size(); ++k)
    driven_[k].position_m = prescribed_[k].position_m(time_s_ + tick.length_s);
  for (std::size_t hand = 0; hand < hands_; ++hand) {
    DrivenPose& pose = driven_[driven_of_hand(hand)];
    pose.is_here = hand < tick.tools.size() && tick.tools[hand].has_value();
    if (!pose.is_here) continue;
    const ToolPose& end = *tick.tools[hand];
    const std::size_t r = rigid_of_hand(hand);
    // A tool comes at its velocity.
    const bool comes = state.is_here[r] == 0;
    const Eigen::Vector3d from_m =
        comes ? Eigen::Vector3d(end.position_m - tick.left_s * end.velocity_m_s)
              : state.rigid_position_m[r].vector();
    const Eigen::Quaterniond from = comes ? end.orientation : state.orientation[r].quaternion();
    const double share = tick.length_s / tick.left_s;
    pose.position_m = from_m + share * (end.position_m - from_m);
    pose.orientation =
        rotation_by(share * rotation_vector(end.orientation * from.conjugate())) * from;
    pose.velocity_m_s = end.velocity_m_s;
    if (share < 1.0) continue;
    pose.position_m = end.position_m;
    pose.orientation = end.orientation;
  }
}

void SceneTicks::step(const Tick& tick) {
  aim(tick);
  engine_->step(driven_, tick.length_s, tick.substeps);
  time_s_ += tick.length_s;
}

double SceneTicks::counted_ns(double substeps, double products) const noexcept {
  constexpr double kRowsOfField = 0.5;  // a contact with a field takes as long as half a row
  const ContactListing& listing = engine_->listing();
  const double rows = static_cast<double>(listing.rows().rows.size()) +
                      kRowsOfField * static_cast<double>(listing.field_lanes().size());
  return counted_listing_ns(counts_, listing.near_pairs(), listing.comparisons()) +
         counted_tick_ns(counts_, substeps, products, rows);
}

double SceneTicks::counted_ns() const noexcept {
  return counted_ns(engine_->substeps(), static_cast<double>(engine_->solve().products));
}

double SceneTicks::next_counted_ns() {
  return counted_ns(engine_->needed_substeps(kTick_s), 0.0);
}

void SceneTicks::save(std::vector<std::byte>& block) const {
  engine_->save(block);
  block.resize(block.size() + sizeof time_s_);
  std::memcpy(block.data() + block.size() - sizeof time_s_, &time_s_, sizeof time_s_);
}

void SceneTicks::load(std::span<const std::byte> block) {
  double time_s = 0.0;
  if (block.size() < sizeof time_s) throw std::invalid_argument("the block ends too early");
  std::memcpy(&time_s, block.last(sizeof time_s).data(), sizeof time_s);
  if (!(std::abs(time_s) < 1e12)) throw std::invalid_argument("the block's time is not a time");
  engine_->load(block.first(block.size() - sizeof time_s));
  time_s_ = time_s;
}

/// Draws all that moves together, or apart, about the middle of all: on the first plane, if any.
void SceneTicks::draw(double share, const SceneState& start) {
  const Description& description = engine_->description();
  SceneState state = start;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  const auto count =
      static_cast<double>(state.node_position_m.size() + state.rigid_position_m.size());
  for (const auto* positions_m : {&state.node_position_m, &state.rigid_position_m})
    for (const Vector4& position_m : *positions_m) centre_m += position_m.vector() / count;
  if (!description.planes.empty()) {
    const Description::Plane& plane = description.planes.front();
    centre_m -= (plane.normal.dot(centre_m) - plane.offset_m) * plane.normal;
  }
  const auto move = [&](Vector4& position_m) {
    const double w = position_m.w;
    position_m = Vector4(Eigen::Vector3d(centre_m + share * (position_m.vector() - centre_m)));
    position_m.w = w;
  };
  for (Vector4& position_m : state.node_position_m) move(position_m);
  for (std::size_t r = 0; r < state.rigid_position_m.size(); ++r)
    if (!description.rigid_bodies[r].is_fixture) move(state.rigid_position_m[r]);
  engine_->set_state(std::move(state));
  const std::vector<std::optional<ToolPose>> tools(hands_, ToolPose{.position_m = centre_m});
  for (int tick = 0; tick < 2; ++tick) step({.substeps = 1, .tools = tools});
}

/// Those of the spheres of a hand's tool, among values of all tools' spheres.
std::span<const Vector4> SceneTicks::of_hand(const std::vector<Vector4>& values,
                                             std::size_t hand) const noexcept {
  const auto rigid = static_cast<int>(rigid_of_hand(hand));
  const std::span<const std::int32_t> tools = engine_->listing().tools();
  const auto is_of_hand = [&](std::int32_t sphere) {
    return engine_->description().spheres[at(sphere)].rigid == rigid;
  };
  const auto first = std::find_if(tools.begin(), tools.end(), is_of_hand);
  const auto end = std::find_if_not(first, tools.end(), is_of_hand);
  return {values.data() + (first - tools.begin()), static_cast<std::size_t>(end - first)};
}

void SceneTicks::warm_up() {
  std::vector<std::byte> block, drawn;
  save(block);
  const SceneState start = engine_->state();
  // Together and with the tools in their midst bodies have more contacts than they will have, apart
  // they need more cells.
  for (const double share : {3.0, 0.9, 0.6, 0.3}) {
    draw(share, start);
    save(drawn);
    load(drawn);
    load(block);
  }
}

}  // namespace stillgrid::dynamics

#include "shared/local/local_scene.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "proto/segment_header.hpp"

namespace stillgrid::local {
namespace {

/// Ticks by which a copy catches up in one tick of the hand: with three a copy that is a second
/// behind is there in half a second.
constexpr int kCatchUpTicks = 3;
/// Missed ticks that are made up for in one tick.
constexpr std::uint64_t kMaxTicks = 8;
/// Ticks between a state and the newest sample of the tool.
constexpr std::uint64_t kMaxLag = 1000;

/// Whether positions and velocities are numbers that a reader takes.
bool is_plausible(const dynamics::SceneState& state) {
  const auto is_one = [](double number) { return std::abs(number) <= proto::kLargestNumber; };
  for (const auto* values : state.vectors())
    for (const dynamics::Vector4& v : *values)
      if (!is_one(v.x) || !is_one(v.y) || !is_one(v.z) || !is_one(v.w)) return false;
  return true;
}

using Distances = std::span<const std::shared_ptr<const collision::DistanceField>>;

dynamics::SceneModel model_of_hands(std::span<const std::byte> bytes, Distances distances,
                                    std::size_t hands) {
  dynamics::SceneModel model = dynamics::decode(bytes, distances);
  if (model.hands != hands)
    throw std::invalid_argument("the model has " + std::to_string(model.hands) +
                                " hands; expected " + std::to_string(hands));
  if (!(dynamics::counted_tick_ns(model) <= dynamics::kLongestTick_ns))
    throw std::invalid_argument("a tick of the scene takes too long");
  return model;
}

}  // namespace

LocalScene::LocalScene(std::span<const std::byte> model, Distances distances, std::size_t hands,
                       std::size_t own_hand)
    : LocalScene(model_of_hands(model, distances, hands), own_hand) {}

LocalScene::LocalScene(const dynamics::SceneModel& model, std::size_t own_hand)
    : copies_{Copy(model), Copy(model)},
      tools_(model.hands),
      own_hand_(own_hand),
      poses_(model.hands),
      passed_(kPassed) {
  if (own_hand >= model.hands) throw std::invalid_argument("the model has no such hand");
  for (Copy& copy : copies_) copy.ticks.warm_up();
}

std::optional<dynamics::ToolPose> LocalScene::Tool::pose_at(std::uint64_t tick) const noexcept {
  const std::uint64_t newest = path.newest().value_or(tick);
  const std::uint64_t led_on = tick - std::min(tick, newest);
  if (led_on > led_on_ticks) return std::nullopt;
  std::optional<dynamics::ToolPose> pose = path.pose_at(tick - led_on);
  if (pose && led_on > 0)
    pose->position_m += static_cast<double>(led_on) * dynamics::kTick_s * pose->velocity_m_s;
  return pose;
}

bool LocalScene::confirms(std::uint64_t tick, std::uint64_t hash) const noexcept {
  const Copy& next = other();
  if (!next.is_begun && !shown_->is_begun) return false;
  if (next.is_begun && tick > next.tick) return true;  // it is on its way
  const Passed& passed = passed_[tick % kPassed];
  return passed.tick == tick && passed.hash == hash;
}

bool LocalScene::begin_at(std::uint64_t tick, std::span<const std::byte> state) {
  Copy& next = other();
  next.is_begun = false;
  const std::uint64_t known = tools_[own_hand_].path.newest().value_or(0);
  if (tick > known + kMaxLag || tick + kMaxLag < known) return false;
  try {
    next.ticks.load(state);
  } catch (const std::exception&) {
    return false;
  }
  if (!is_plausible(next.ticks.engine().state()) ||
      next.ticks.next_counted_ns() > 2.0 * dynamics::kLongestTick_ns)
    return false;
  next.tick = tick;
  next.is_begun = true;
  note(next);
  return true;
}

void LocalScene::note(const Copy& copy) noexcept {
  passed_[copy.tick % kPassed] = {copy.tick, dynamics::hash(copy.ticks.engine().state())};
}

void LocalScene::step(Copy& copy) {
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    poses_[hand] = tools_[hand].pose_at(copy.tick + 1);
  copy.ticks.step({.tools = poses_});
  ++copy.tick;
  note(copy);
  // One that takes too long would take the hand's ticks; the next state may be of less contact.
  if (copy.ticks.counted_ns() > 2.0 * dynamics::kLongestTick_ns) copy.is_begun = false;
}

Advance LocalScene::advance_to(std::uint64_t tick) {
  Advance advance;
  const auto step_by_one = [&](Copy& copy) {
    step(copy);
    ++advance.ticks;
  };
  // Behind its newest point the own path is not known yet.
  const std::uint64_t known = std::min(tick, tools_[own_hand_].path.newest().value_or(0));
  // One that is too far behind waits for a state that is nearer.
  if (shown_->tick + kMaxTicks < known) shown_->is_begun = false;
  while (shown_->is_begun && shown_->tick < known) step_by_one(*shown_);
  Copy& next = other();
  for (int k = 0; next.is_begun && next.tick < known && k < kCatchUpTicks; ++k) step_by_one(next);
  if (next.is_begun && next.tick >= known) {
    shown_->is_begun = false;
    shown_ = &next;
    advance.is_swap = true;
  }
  shown_->is_begun = shown_->is_begun && is_plausible(shown_->ticks.engine().state());
  advance.is_known = shown_->is_begun && shown_->tick == tick;
  return advance;
}

}  // namespace stillgrid::local

#include "shared/local/local_scene.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

namespace stillgrid::local {
namespace {

/// Ticks by which a copy catches up in one tick of the hand: with three a copy that is a second
/// behind is there in half a second.
constexpr int kCatchUpTicks = 3;

using Distances = std::span<const std::shared_ptr<const collision::DistanceField>>;

dynamics::SceneModel one_handed(std::span<const std::byte> bytes, Distances distances) {
  dynamics::SceneModel model = dynamics::decode(bytes, distances);
  if (model.hands != 1)
    throw std::invalid_argument("the scene has " + std::to_string(model.hands) +
                                " hands; expected one");
  if (!(dynamics::counted_tick_ns(model) <= dynamics::kLongestTick_ns))
    throw std::invalid_argument("a tick of the scene takes too long");
  return model;
}

}  // namespace

LocalScene::LocalScene(std::span<const std::byte> model, Distances distances)
    : LocalScene(one_handed(model, distances)) {}

LocalScene::LocalScene(const dynamics::SceneModel& model)
    : copies_{Copy(model), Copy(model)}, passed_(kPassed) {}

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
  try {
    next.ticks.load(state);
  } catch (const std::invalid_argument&) {
    return false;
  }
  next.tick = tick;
  next.is_begun = true;
  note(next);
  return true;
}

void LocalScene::note(const Copy& copy) noexcept {
  passed_[copy.tick % kPassed] = {copy.tick, dynamics::hash(copy.ticks.engine().state())};
}

void LocalScene::step(Copy& copy) {
  std::optional<dynamics::ToolPose> pose;
  if (const auto at = path_.pose_at(copy.tick + 1))
    pose = {at->position_m, at->orientation, at->velocity_m_s};
  copy.ticks.step({.tools = std::span(&pose, 1)});
  ++copy.tick;
  note(copy);
}

bool LocalScene::advance_to(std::uint64_t tick) {
  caught_up_ = 0;
  // Behind its newest point the path is not known yet.
  const std::uint64_t known = std::min(tick, path_.newest().value_or(0));
  while (shown_->is_begun && shown_->tick < known) step(*shown_);
  Copy& next = other();
  for (; next.is_begun && next.tick < known && caught_up_ < kCatchUpTicks; ++caught_up_) step(next);
  if (next.is_begun && next.tick >= known) {
    shown_->is_begun = false;
    shown_ = &next;
  }
  return shown_->is_begun && shown_->tick == tick;
}

}  // namespace stillgrid::local

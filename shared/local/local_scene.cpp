#include "shared/local/local_scene.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "proto/segment_header.hpp"

namespace stillgrid::local {
namespace {

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

bool SimulatedCopy::is_plausible() const noexcept {
  const auto is_one = [](double number) { return std::abs(number) <= proto::kLargestNumber; };
  for (const auto* values : ticks.engine().state().vectors())
    for (const dynamics::Vector4& v : *values)
      if (!is_one(v.x) || !is_one(v.y) || !is_one(v.z) || !is_one(v.w)) return false;
  return true;
}

LocalScene::LocalScene(std::span<const std::byte> model, Distances distances, std::size_t hands,
                       std::size_t own_hand)
    : LocalScene(model_of_hands(model, distances, hands), own_hand) {}

LocalScene::LocalScene(const dynamics::SceneModel& model, std::size_t own_hand)
    : SceneCopies(model, model.hands, own_hand), passed_(kPassed) {
  if (own_hand >= model.hands) throw std::invalid_argument("the model has no such hand");
  for (SimulatedCopy& copy : copies()) copy.ticks.warm_up();
}

bool LocalScene::confirms(std::uint64_t tick, std::uint64_t hash) const noexcept {
  if (!next().is_begun && !shown().is_begun) return false;
  if (next().is_begun && tick > next().tick) return true;  // it is on its way
  const Passed& passed = passed_[tick % kPassed];
  return passed.tick == tick && passed.hash == hash;
}

bool LocalScene::begin_at(std::uint64_t tick, std::span<const std::byte> state) {
  SimulatedCopy& copy = next();
  copy.is_begun = false;
  if (!can_begin_at(tick)) return false;
  try {
    copy.ticks.load(state);
  } catch (const std::exception&) {
    return false;
  }
  if (!copy.is_plausible() || copy.ticks.next_counted_ns() > dynamics::kLongestTickWithContacts_ns)
    return false;
  copy.tick = tick;
  copy.is_begun = true;
  note(copy);
  return true;
}

void LocalScene::note(const SimulatedCopy& copy) noexcept {
  passed_[copy.tick % kPassed] = {copy.tick, dynamics::hash(copy.ticks.engine().state())};
}

void LocalScene::step(SimulatedCopy& copy) {
  copy.ticks.step({.tools = poses_at(copy.tick + 1)});
  ++copy.tick;
  note(copy);
  // One that takes too long would take the hand's ticks; the next state may be of less contact.
  if (copy.ticks.counted_ns() > dynamics::kLongestTickWithContacts_ns) copy.is_begun = false;
}

Advance LocalScene::advance_to(std::uint64_t tick) {
  return advance(
      tick, [this](SimulatedCopy& copy) { step(copy); }, [] {});
}

}  // namespace stillgrid::local

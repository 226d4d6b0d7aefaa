#include "shared/local/given_scene.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace stillgrid::local {
namespace {

/// As of LocalScene: ticks by which a copy catches up in one, missed ticks that are made up for in
/// one, and ticks between a state and the tool's newest sample.
constexpr int kCatchUpTicks = 3;
constexpr std::uint64_t kMaxTicks = 8, kMaxLag = 1000;

}  // namespace

GivenScene::GivenScene(std::span<const std::byte> model, std::size_t hands, std::size_t own_hand)
    : GivenScene(decode_given_model(model), hands, own_hand) {}

GivenScene::GivenScene(const GivenModel& model, std::size_t hands, std::size_t own_hand)
    : copies_{Copy(model), Copy(model)}, tools_(hands), own_hand_(own_hand), poses_(hands) {
  if (model.tools.size() != hands || own_hand >= hands)
    throw std::invalid_argument("the model has another number of hands");
  decoded_.bodies.reserve(kMaxGivenBodies);
  for (auto* shifts : {&shifts_m_, &next_shifts_m_}) shifts->reserve(kMaxGivenSpheres);
  decoded_.spheres.reserve(kMaxGivenSpheres);
}

bool GivenScene::confirms(std::uint64_t tick, std::uint64_t /*hash*/) const noexcept {
  const Copy& next = other();
  if (next.is_begun) return true;
  return shown_->is_begun && shown_->began >= tick;
}

bool GivenScene::begin_at(std::uint64_t tick, std::span<const std::byte> state) noexcept {
  Copy& next = other();
  next.is_begun = false;
  const std::uint64_t known = tools_[own_hand_].path.newest().value_or(0);
  if (tick > known + kMaxLag || tick + kMaxLag < known) return false;
  if (!decode(state, next.bodies.model().materials.size(), decoded_)) return false;
  next.bodies.begin(decoded_);
  next.tick = next.began = tick;
  next.is_begun = true;
  return true;
}

void GivenScene::step(Copy& copy) noexcept {
  ++copy.tick;
  if (copy.tick > copy.began + 2 * copy.bodies.model().period_ticks) return copy.bodies.stand();
  for (std::size_t hand = 0; hand < tools_.size(); ++hand)
    poses_[hand] = dynamics::led_on_pose(tools_[hand].path, copy.tick, tools_[hand].led_on_ticks);
  copy.bodies.step(poses_);
}

Eigen::Vector3d GivenScene::position_m(std::size_t i) const noexcept {
  const GivenBodies& bodies = shown_->bodies;
  const double left = 1.0 - 2.0 * static_cast<double>(shown_->tick - swapped_) /
                                static_cast<double>(bodies.model().period_ticks);
  return bodies.position_m(bodies.spheres()[i]) + std::max(0.0, left) * shifts_m_[i];
}

/// Keeps by how much the shown spheres stand elsewhere in the next copy. Both are in the order of
/// bodies and spheres.
void GivenScene::shift(const Copy& next) noexcept {
  const auto before = shown_->bodies.spheres(), after = next.bodies.spheres();
  const auto order = [](const Copy& copy, const GivenSphere& sphere) {
    return std::pair(copy.bodies.bodies()[sphere.body].number, sphere.number);
  };
  next_shifts_m_.assign(after.size(), Eigen::Vector3d::Zero());
  const bool are_both = shown_->is_begun && shown_->tick == next.tick;
  for (std::size_t i = 0, k = 0; are_both && i < before.size() && k < after.size();) {
    const auto of_before = order(*shown_, before[i]), of_after = order(next, after[k]);
    if (of_before == of_after) next_shifts_m_[k] = position_m(i) - next.bodies.position_m(after[k]);
    i += of_before <= of_after;
    k += of_after <= of_before;
  }
  std::swap(shifts_m_, next_shifts_m_);
  swapped_ = next.tick;
}

Advance GivenScene::advance_to(std::uint64_t tick) noexcept {
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
    shift(next);
    shown_->is_begun = false;
    shown_ = &next;
    advance.is_swap = true;
  }
  shown_->is_begun = shown_->is_begun && shown_->bodies.is_plausible();
  advance.is_known = shown_->is_begun && shown_->tick == tick;
  return advance;
}

}  // namespace stillgrid::local

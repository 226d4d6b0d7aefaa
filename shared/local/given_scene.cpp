#include "shared/local/given_scene.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace stillgrid::local {

GivenScene::GivenScene(std::span<const std::byte> model, std::size_t hands, std::size_t own_hand)
    : GivenScene(decode_given_model(model), hands, own_hand) {}

GivenScene::GivenScene(const GivenModel& model, std::size_t hands, std::size_t own_hand)
    : SceneCopies(model, hands, own_hand) {
  if (model.tools.size() != hands || own_hand >= hands)
    throw std::invalid_argument("the model has another number of hands");
  decoded_.bodies.reserve(kMaxGivenBodies);
  for (auto* shifts : {&shifts_m_, &next_shifts_m_}) shifts->reserve(kMaxGivenSpheres);
  decoded_.spheres.reserve(kMaxGivenSpheres);
}

bool GivenScene::confirms(std::uint64_t tick, std::uint64_t /*hash*/) const noexcept {
  if (next().is_begun) return true;
  return shown().is_begun && shown().began >= tick;
}

bool GivenScene::begin_at(std::uint64_t tick, std::span<const std::byte> state) noexcept {
  GivenCopy& copy = next();
  copy.is_begun = false;
  if (!can_begin_at(tick)) return false;
  if (!decode(state, copy.bodies.model().materials.size(), decoded_)) return false;
  copy.bodies.begin(decoded_);
  copy.tick = copy.began = tick;
  copy.is_begun = true;
  return true;
}

void GivenScene::step(GivenCopy& copy) noexcept {
  ++copy.tick;
  if (copy.tick > copy.began + 2 * copy.bodies.model().period_ticks) return copy.bodies.stand();
  copy.bodies.step(poses_at(copy.tick));
}

Eigen::Vector3d GivenScene::position_m(std::size_t i) const noexcept {
  const GivenBodies& bodies = shown().bodies;
  const double left = 1.0 - 2.0 * static_cast<double>(shown().tick - swapped_) /
                                static_cast<double>(bodies.model().period_ticks);
  return bodies.position_m(bodies.spheres()[i]) + std::max(0.0, left) * shifts_m_[i];
}

/// Keeps by how much the shown spheres stand elsewhere in the next copy. Both are in the order of
/// bodies and spheres.
void GivenScene::shift() noexcept {
  const auto before = shown().bodies.spheres(), after = next().bodies.spheres();
  const auto order = [](const GivenCopy& copy, const GivenSphere& sphere) {
    return std::pair(copy.bodies.bodies()[sphere.body].number, sphere.number);
  };
  next_shifts_m_.assign(after.size(), Eigen::Vector3d::Zero());
  const bool are_both = shown().is_begun && shown().tick == next().tick;
  for (std::size_t i = 0, k = 0; are_both && i < before.size() && k < after.size();) {
    const auto of_before = order(shown(), before[i]), of_after = order(next(), after[k]);
    if (of_before == of_after)
      next_shifts_m_[k] = position_m(i) - next().bodies.position_m(after[k]);
    i += of_before <= of_after;
    k += of_after <= of_before;
  }
  std::swap(shifts_m_, next_shifts_m_);
  swapped_ = next().tick;
}

Advance GivenScene::advance_to(std::uint64_t tick) noexcept {
  return advance(
      tick, [this](GivenCopy& copy) { step(copy); }, [this] { shift(); });
}

}  // namespace stillgrid::local

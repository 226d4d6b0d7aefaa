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
  for (OwnProxies* all : {&proxies_m_, &stretches_m_}) {
    all->shown.resize(model.tools[own_hand].spheres.size());
    all->shifts.resize(all->shown.size());
  }
  decoded_.spheres.reserve(kMaxGivenSpheres);
  decoded_.proxies.reserve(kMaxGivenProxies);
}

bool GivenScene::confirms(std::uint64_t tick, std::uint64_t /*hash*/) const noexcept {
  if (next().is_begun) return true;
  return shown().is_begun && shown().began >= tick;
}

bool GivenScene::begin_at(std::uint64_t tick, std::span<const std::byte> state) noexcept {
  GivenCopy& copy = next();
  copy.is_begun = false;
  if (!can_begin_at(tick)) return false;
  if (!decode(state, copy.bodies.model(), decoded_)) return false;
  copy.bodies.begin(decoded_, poses_at(tick));
  copy.tick = copy.began = tick;
  copy.is_begun = true;
  return true;
}

void GivenScene::step(GivenCopy& copy) noexcept {
  ++copy.tick;
  if (copy.tick > copy.began + 2 * copy.bodies.model().period_ticks) copy.bodies.stand();
  copy.bodies.step(poses_at(copy.tick));
}

Eigen::Vector3d GivenScene::position_m(std::size_t i) const noexcept {
  const GivenBodies& bodies = shown().bodies;
  return bodies.position_m(bodies.spheres()[i]) + left() * shifts_m_[i];
}

/// A proxy's place, or the stretch of its friction. w is 0 if nothing holds it.
dynamics::Vector4 GivenScene::proxy_of(const GivenCopy& copy, std::size_t i,
                                       Eigen::Vector3d GivenProxy::*vector) const noexcept {
  const GivenProxy& proxy = copy.bodies.tools().proxies(own_hand())[i];
  if (!copy.is_begun || !proxy.is_here || proxy.position_m == proxy.device_m) return {};
  dynamics::Vector4 known(proxy.*vector);
  known.w = proxy.is_let_out ? 0.5 : 1.0;
  return known;
}

/// What is left of the offset at the last swap.
double GivenScene::left() const noexcept {
  const auto period = static_cast<double>(shown().bodies.model().period_ticks);
  return std::max(0.0, 1.0 - 2.0 * static_cast<double>(shown().tick - swapped_) / period);
}

std::span<const dynamics::Vector4> GivenScene::own(OwnProxies& all) noexcept {
  for (std::size_t i = 0; i < all.shown.size(); ++i) {
    const dynamics::Vector4 known = proxy_of(shown(), i, all.vector);
    all.shown[i] = known.w > 0.0 ? known + left() * all.shifts[i] : known;
    all.shown[i].w = known.w;
  }
  return all.shown;
}

/// Keeps by how much the own proxies are elsewhere in the next copy.
void GivenScene::shift(OwnProxies& all) noexcept {
  const std::span<const dynamics::Vector4> before = own(all);
  const bool are_both = shown().is_begun && shown().tick == next().tick;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const dynamics::Vector4 after = proxy_of(next(), i, all.vector);
    const bool is_both = are_both && before[i].w > 0.0 && after.w > 0.0;
    all.shifts[i] = is_both ? before[i] - after : dynamics::Vector4();
  }
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
  shift(proxies_m_);
  shift(stretches_m_);
  std::swap(shifts_m_, next_shifts_m_);
  swapped_ = next().tick;
}

Advance GivenScene::advance_to(std::uint64_t tick) noexcept {
  return advance(
      tick, [this](GivenCopy& copy) { step(copy); }, [this] { shift(); });
}

}  // namespace stillgrid::local

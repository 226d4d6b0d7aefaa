#include "haptic_server/safety/interface_account.hpp"

#include <algorithm>
#include <cmath>

#include "proto/tool_segment.hpp"

namespace stillgrid::safety {
namespace {

constexpr double kRemembered_s = 4.0;
constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::size_t ticks_in(double duration_s, double period_s) {
  constexpr double kMax = 1e6;
  return 2 + static_cast<std::size_t>(std::clamp(duration_s / period_s, 1.0, kMax));
}

/// What is no number is none.
double number(double value) {
  return std::isfinite(value) ? value : 0.0;
}

/// By contacts with what moves.
double stored_J(const RenderedScene& scene) {
  if (!(scene.stiffness_N_per_m > 0.0)) return 0.0;
  const double all_J = 0.5 * scene.rendered.force_N.squaredNorm() / scene.stiffness_N_per_m;
  return number(std::max(0.0, all_J - scene.static_J));
}

}  // namespace

InterfaceAccount::InterfaceAccount(double period_s) : ring_(ticks_in(kRemembered_s, period_s)) {}

void InterfaceAccount::begin(const RenderedScene& scene) noexcept {
  given_by_earlier_J_ = given_by_scenes_J();
  epoch_ = scene.epoch;
  snapshot_id_ = 0;
  first_ = young_ = end_;
  is_known_ = is_refused_ = false;
  held_ = {};
  given_J_ = noise_J_ = 0.0;
  joined_ = last_ = {};
  scale_ = scene.scale;
  least_made_J_ = std::numeric_limits<double>::infinity();
  energy_ = {};
}

/// The first young tick is so no longer.
void InterfaceAccount::age() noexcept {
  const double made_J = at(young_++).made_J;
  if (made_J < least_made_J_) least_made_J_ = made_J;
}

void InterfaceAccount::push(const Tick& tick) noexcept {
  if (end_ - first_ == ring_.size()) {
    if (young_ == first_) age();
    ++first_;
  }
  at(end_++) = tick;
}

InterfaceAccount::Tick* InterfaceAccount::tick_at(std::uint64_t time_ns) noexcept {
  std::uint64_t low = first_, high = end_;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (at(middle).time_ns < time_ns)
      low = middle + 1;
    else
      high = middle;
  }
  const bool is_there =
      low < end_ && at(low).time_ns / proto::kPathTick_ns == time_ns / proto::kPathTick_ns;
  return is_there ? &at(low) : nullptr;
}

void InterfaceAccount::join(std::uint64_t tool_time_ns, double tool_work_J) noexcept {
  if (tool_time_ns == 0 || tool_time_ns < at(first_).time_ns) return;  // too late, or another's
  if (tool_time_ns > at(end_ - 1).time_ns || tool_time_ns < joined_.time_ns) {
    is_refused_ = true;
    return;
  }
  Tick* const tick = tick_at(tool_time_ns);
  if (tick == nullptr) return;  // missed: the path went evenly over it
  energy_.booked_J = tool_work_J - booked_before_J_;
  energy_.made_J = tick->made_J = energy_.booked_J + tick->held_J - tick->given_J;
  energy_.noise_J = tick->noise_J;
  joined_ = *tick;
  is_known_ = true;
  while (at(young_).time_ns + kSecond_ns <= tool_time_ns) age();
  if (!std::isfinite(least_made_J_)) return;
  const double made_J = energy_.made_J - least_made_J_;
  energy_.most_made_in_a_second_J =
      std::max(energy_.most_made_in_a_second_J.value_or(made_J), made_J);
}

void InterfaceAccount::note(std::uint64_t now_ns, const DeviceMotion& motion,
                            const RenderedScene& scene) noexcept {
  if (scene.epoch != epoch_) begin(scene);
  const double newest_J = work_J(held_[0], motion);
  given_J_ -= newest_J;
  noise_J_ += newest_J - 2.0 * work_J(held_[1], motion) + work_J(held_[2], motion);
  const bool is_number =
      scene.rendered.force_N.allFinite() && scene.rendered.torque_N_m.allFinite();
  held_ = {is_number ? scene.rendered : Wrench{}, held_[0], held_[1]};
  last_ = {now_ns, given_J_, number(scene.static_J), stored_J(scene), noise_J_, kNone};
  push(last_);
  if (scene.snapshot_id == 0 || is_refused_) return;
  can_move_ = scene.can_move;
  const bool is_first = snapshot_id_ == 0;
  if (scene.snapshot_id == snapshot_id_ && can_move_) return;
  snapshot_id_ = scene.snapshot_id;
  if (!(std::abs(scene.tool_work_J) <= proto::kLargestNumber) || !std::isfinite(given_J_)) {
    is_refused_ = true;
    return;
  }
  if (is_first) {
    booked_before_J_ = scene.tool_work_J;
    at(end_ - 1).made_J = 0.0;
  }
  // Where nothing can move there is nothing to wait for.
  join(can_move_ ? scene.tool_time_ns : now_ns, scene.tool_work_J);
}

std::optional<InterfaceEnergy> InterfaceAccount::energy() const noexcept {
  if (!is_known_ || is_refused_) return std::nullopt;
  InterfaceEnergy energy = energy_;
  energy.given_by_hand_J = given_J_;
  energy.held_J = last_.held_J;
  energy.in_flight_J = given_J_ - last_.held_J - (joined_.given_J - joined_.held_J);
  if (can_move_)
    energy.uncertainty_J =
        std::abs(energy.in_flight_J) + std::max(last_.stored_J, joined_.stored_J);
  return energy;
}

double InterfaceAccount::given_by_scenes_J() const noexcept {
  const std::optional<InterfaceEnergy> now = energy();
  if (!now) return given_by_earlier_J_;
  return given_by_earlier_J_ + std::max(0.0, now->uncertainty_J - now->booked_J) / scale_;
}

}  // namespace stillgrid::safety

#pragma once

#include <array>
#include <cmath>

namespace stillgrid::collision {

/// Returns whether the squared norm of a quaternion is 1 within 1e-3. A NaN is no unit quaternion.
/// Realtime: yes.
template <class Number>
[[nodiscard]] bool is_unit(const std::array<Number, 4>& quaternion) noexcept {
  double norm_squared = 0.0;
  for (const Number q : quaternion) norm_squared += double{q} * double{q};
  return std::abs(norm_squared - 1.0) < 1e-3;
}

}  // namespace stillgrid::collision

#pragma once

#include <Eigen/Core>
#include <array>

namespace stillgrid::library {

/// As records have them, and back. Realtime: yes.
[[nodiscard]] inline Eigen::Vector3d vector(const std::array<float, 3>& v) noexcept {
  return {v[0], v[1], v[2]};
}
[[nodiscard]] inline std::array<float, 3> floats(const Eigen::Vector3d& v) noexcept {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace stillgrid::library

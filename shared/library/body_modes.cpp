#include "shared/library/body_modes.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace stillgrid::library {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Of the largest eigenvalue: what is less is rounding.
constexpr double kRounding = 1e-9;
/// Of the largest entry.
constexpr double kSymmetry = 1e-6;

}  // namespace

bool BodyModes::take(const stillgrid_response& response) noexcept {
  body_ = response.body;
  centre_m_ = Eigen::Vector3d(response.centre_m);
  count_ = 0;
  const Matrix6 given =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(response.inverse_inertia);
  if (!((given - given.transpose()).cwiseAbs().maxCoeff() <=
        kSymmetry * given.cwiseAbs().maxCoeff()))
    return false;
  // In one unit: turns by the way that they make at the body's own length.
  const double along = given.topLeftCorner<3, 3>().trace();
  const double about = given.bottomRightCorner<3, 3>().trace();
  const double length_m = along > 0.0 && about > 0.0 ? std::sqrt(along / about) : 1.0;
  Twist unit = Twist::Ones();
  unit.tail<3>().setConstant(length_m);
  const Matrix6 scaled =
      unit.asDiagonal() * (0.5 * (given + given.transpose())) * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solved(scaled);
  const double largest = solved.eigenvalues().cwiseAbs().maxCoeff();
  if (!(solved.eigenvalues().minCoeff() >= -kSymmetry * largest)) return false;
  for (int i = 5; i >= 0; --i) {
    const double eigenvalue = solved.eigenvalues()[i];
    if (!(eigenvalue > kRounding * largest)) break;
    motions_.col(count_++) =
        unit.cwiseInverse().cwiseProduct(std::sqrt(eigenvalue) * solved.eigenvectors().col(i));
  }
  return true;
}

Twist BodyModes::wrench_of(std::span<const stillgrid_push> pushes) const noexcept {
  Twist wrench = Twist::Zero();
  for (const stillgrid_push& push : pushes) {
    if (push.body != body_) continue;
    const Eigen::Vector3d force_N(push.force_N), arm_m = Eigen::Vector3d(push.point_m) - centre_m_;
    wrench.head<3>() += force_N;
    wrench.tail<3>() += Eigen::Vector3d(push.torque_N_m) + arm_m.cross(force_N);
  }
  return wrench;
}

}  // namespace stillgrid::library

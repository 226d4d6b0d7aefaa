#include "sim_server/bodies/rotation.hpp"

#include <catch2/catch.hpp>
#include <numbers>

namespace stillgrid::bodies::rotation_test {
namespace {

const Eigen::Vector3d kAxis = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();

TEST_CASE("The cross matrix is the cross product", "[rotation]") {
  const Eigen::Vector3d a(1.0, -2.0, 3.0), b(0.5, 4.0, -1.0);

  CHECK((cross_matrix(a) * b - a.cross(b)).norm() == 0.0);
  CHECK((cross_matrix(a) + cross_matrix(a).transpose()).norm() == 0.0);
}

TEST_CASE("A rotation vector turns by its length about its direction", "[rotation]") {
  const double angle_rad =
      GENERATE(0.0, 1e-12, 1e-9, 1.1e-8, 1e-4, 0.3, 2.0, std::numbers::pi, 7.0);

  const Eigen::Quaterniond rotation = rotation_of(angle_rad * kAxis);

  const Eigen::Quaterniond expected(Eigen::AngleAxisd(angle_rad, kAxis));
  CHECK((rotation.coeffs() - expected.coeffs()).norm() < 1e-15);
  CHECK(rotation.norm() == Approx(1.0).epsilon(1e-15));
}

TEST_CASE("The left Jacobian is the derivative of the rotation by its vector", "[rotation]") {
  const double angle_rad = GENERATE(0.0, 1e-6, 0.99e-4, 1.01e-4, 0.1, 1.5, 3.0, 5.0);
  const Eigen::Vector3d vector_rad = angle_rad * kAxis;
  const Eigen::Matrix3d jacobian = left_jacobian(vector_rad);
  // The second-order terms of a central difference are its error: 1e-10 here, and as much rounding.
  constexpr double kStep_rad = 1e-5;

  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d change_rad = kStep_rad * Eigen::Vector3d::Unit(i);
    const Eigen::Quaterniond turn =
        rotation_of(vector_rad + change_rad) * rotation_of(vector_rad - change_rad).conjugate();
    const Eigen::Vector3d slope = turn.vec() / kStep_rad;
    CHECK((slope - jacobian.col(i)).norm() < 1e-9);
  }
}

TEST_CASE("The left Jacobian does not jump where its series takes over", "[rotation]") {
  const Eigen::Matrix3d below = left_jacobian(0.999999e-4 * kAxis);
  const Eigen::Matrix3d above = left_jacobian(1.000001e-4 * kAxis);

  CHECK((above - below).norm() < 1e-9);
}

}  // namespace
}  // namespace stillgrid::bodies::rotation_test

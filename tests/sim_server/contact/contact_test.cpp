#include "sim_server/contact/contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "shared/collision/contact_law.hpp"

namespace stillgrid::contact::contact_test {
namespace {

constexpr double kStep_s = 0.01;
const collision::ContactMaterial kMaterial{800.0, 3.0, 0.4, 0.05};

Contact spheres(double depth_before_m) {
  Contact contact;
  contact.material = kMaterial;
  contact.radius_a_m = 0.02;
  contact.radius_b_m = 0.01;
  contact.depth_before_m = depth_before_m;
  return contact;
}

Contact plane(double depth_before_m) {
  Contact contact = spheres(depth_before_m);
  contact.radius_b_m = 0.0;
  contact.is_plane = true;
  contact.plane_normal = Eigen::Vector3d(1, 2, 2) / 3.0;
  contact.plane_offset_m = 0.1;
  return contact;
}

/// Where a is when the contact is depth_m deep, off the axes.
Eigen::Vector3d at_depth_m(const Contact& contact, double depth_m) {
  if (contact.is_plane)
    return (contact.plane_offset_m + contact.radius_a_m - depth_m) * contact.plane_normal +
           Eigen::Vector3d(2, -1, 0);
  return (contact.radius_a_m + contact.radius_b_m - depth_m) *
         Eigen::Vector3d(2, -1, 2).normalized();
}

Eigen::Vector3d normal_of(const Contact& contact) {
  return contact.is_plane ? contact.plane_normal : Eigen::Vector3d(2, -1, 2).normalized();
}

TEST_CASE("Without overlap there is no force", "[contact]") {
  const Contact contact = GENERATE(spheres(0.001), plane(0.001));
  const ContactMotion motion{at_depth_m(contact, -1e-9), {5, 5, 5}, {1, 1, 1}};

  const ContactForce force = contact_force(contact, motion, kStep_s, nullptr);

  CHECK_FALSE(force.touching);
  CHECK(force.force_N.isZero(0.0));
}

TEST_CASE("A contact that does not deepen pushes by its stiffness alone", "[contact]") {
  const double before_m = GENERATE(0.002, 0.005);
  const Contact contact = GENERATE_COPY(spheres(before_m), plane(before_m));
  const ContactMotion motion{at_depth_m(contact, 0.002), {0, 0, 0}, {0, 0, 0}};

  const ContactForce force = contact_force(contact, motion, kStep_s, nullptr);

  CHECK((force.force_N - 1.6 * normal_of(contact)).norm() < 1e-12);
}

TEST_CASE("Over a step the approach damper's impulse is the damping times the deepening",
          "[contact]") {
  // From a gap too, and however long the step: what counts is the depth reached within it.
  const double before_m = GENERATE(-0.5, -0.001, 0.0, 0.0005), step_s = GENERATE(1e-4, 0.01, 0.1);
  const Contact contact = spheres(before_m);
  const ContactMotion motion{at_depth_m(contact, 0.002), {0, 0, 0}, {0, 0, 0}};
  Contact undamped = contact;
  undamped.material.damping_N_s_per_m = 0.0;

  const double impulse_N_s =
      step_s * normal_of(contact).dot(contact_force(contact, motion, step_s, nullptr).force_N -
                                      contact_force(undamped, motion, step_s, nullptr).force_N);

  CHECK(impulse_N_s == Approx(3.0 * (0.002 - std::max(before_m, 0.0))).epsilon(1e-10));
}

TEST_CASE("Force grows from zero at touch", "[contact]") {
  const Contact contact = GENERATE(spheres(-0.01), plane(-0.01));
  const double hardness_N_per_m = 800.0 + 3.0 / kStep_s;

  for (const double depth_m : {1e-3, 1e-6, 1e-9}) {
    const ContactMotion motion{at_depth_m(contact, depth_m), -normal_of(contact), {0, 0, 0}};
    const ContactForce force = contact_force(contact, motion, kStep_s, nullptr);
    CHECK(force.force_N.norm() == Approx(hardness_N_per_m * depth_m).epsilon(1e-6));
  }
}

TEST_CASE("As the step shrinks the contact follows the law of both processes", "[contact]") {
  const Eigen::Vector3d velocity_m_s(0.3, -0.2, -0.7);
  double last_error_N = 1.0;
  for (const double step_s : {1e-3, 1e-4, 1e-5}) {
    Contact contact = spheres(0.0);
    const Eigen::Vector3d end_m = at_depth_m(contact, 0.002);
    contact.depth_before_m = 0.03 - (end_m - step_s * velocity_m_s).norm();
    const Eigen::Vector3d law_N =
        collision::contact_force_N(kMaterial, 0.002, normal_of(contact), velocity_m_s);

    const double error_N =
        (contact_force(contact, {end_m, velocity_m_s, {0, 0, 0}}, step_s, nullptr).force_N - law_N)
            .norm();

    CHECK(error_N < 0.11 * last_error_N);  // first order: the line of centres turns on the way
    last_error_N = error_N;
  }
}

TEST_CASE("A plane's force is the law's at any step", "[contact]") {
  const Eigen::Vector3d velocity_m_s(0.3, -0.2, -0.7);
  Contact contact = plane(0.0);
  contact.depth_before_m = 0.02 + kStep_s * contact.plane_normal.dot(velocity_m_s);
  const ContactMotion motion{at_depth_m(contact, 0.02), velocity_m_s, {0, 0, 0}};
  REQUIRE(contact.depth_before_m > 0.0);

  CHECK((contact_force(contact, motion, kStep_s, nullptr).force_N -
         collision::contact_force_N(kMaterial, 0.02, contact.plane_normal, velocity_m_s))
            .norm() < 1e-12);
}

TEST_CASE("Friction is Coulomb's against the slip, and viscous below the slip speed", "[contact]") {
  const Contact contact = plane(0.02);
  const double slip_m_s = GENERATE(1e-6, 0.01, 0.049, 0.051, 3.0);
  const Eigen::Vector3d along = contact.plane_normal.unitOrthogonal();
  const ContactMotion motion{at_depth_m(contact, 0.005), slip_m_s * along, {0, 0, 0}};

  const ContactForce force = contact_force(contact, motion, kStep_s, nullptr);

  const double normal_load_N = 800.0 * 0.005;
  const double expected_N = 0.4 * normal_load_N * std::min(slip_m_s / 0.05, 1.0);
  CHECK((force.friction_N + expected_N * along).norm() < 1e-12);
}

TEST_CASE("A ball that rolls does not slip", "[contact]") {
  const Contact contact = plane(0.002);
  const Eigen::Vector3d spin_rad_s = 4.0 * contact.plane_normal.unitOrthogonal();
  const Eigen::Vector3d arm_m = contact.radius_a_m * contact.plane_normal;  // to the centre
  const ContactMotion rolling{at_depth_m(contact, 0.002), spin_rad_s.cross(arm_m), spin_rad_s};
  const ContactMotion spinning{at_depth_m(contact, 0.002), {0, 0, 0}, spin_rad_s};

  CHECK(contact_force(contact, rolling, kStep_s, nullptr).friction_N.norm() < 1e-15);
  CHECK(contact_force(contact, spinning, kStep_s, nullptr).friction_N.norm() > 0.1);
}

TEST_CASE("Seen from the other sphere the force is the opposite", "[contact]") {
  const Contact contact = spheres(0.001);
  Contact swapped = contact;
  std::swap(swapped.radius_a_m, swapped.radius_b_m);
  const Eigen::Vector3d spin_a(1, 2, 3), spin_b(-3, 1, 5);
  const auto [share_a, share_b] = contact_shares(contact);
  const Eigen::Vector3d spin = share_a * spin_a + share_b * spin_b;
  const Eigen::Vector3d position_m = at_depth_m(contact, 0.002), velocity_m_s(0.1, 0.2, -0.3);

  const ContactForce one = contact_force(contact, {position_m, velocity_m_s, spin}, 0.01, nullptr);
  const ContactForce other =
      contact_force(swapped, {-position_m, -velocity_m_s, spin}, 0.01, nullptr);

  CHECK((one.force_N + other.force_N).norm() < 1e-14);
  CHECK(share_a == Approx(2.0 / 3.0));
  CHECK(share_a + share_b == 1.0);
  CHECK(contact_shares(plane(0.0)).a == 1.0);
}

TEST_CASE("Concentric spheres push apart along some direction", "[contact]") {
  ContactDerivatives derivatives;
  const ContactForce force =
      contact_force(spheres(0.02), {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, kStep_s, &derivatives);

  CHECK(force.force_N.allFinite());
  CHECK((force.force_N - force.friction_N).norm() == Approx((800.0 * 0.03 + 300.0 * 0.01)));
  CHECK(derivatives.force_by_position.allFinite());
}

/// Force and friction by the nine numbers of a motion.
using NineDerivatives = Eigen::Matrix<double, 6, 9>;

Eigen::Matrix<double, 6, 1> forces_at(const Contact& contact, const ContactMotion& motion,
                                      const Eigen::Matrix<double, 9, 1>& change) {
  const ContactForce force = contact_force(
      contact,
      {motion.position_m + change.segment<3>(0), motion.velocity_m_s + change.segment<3>(3),
       motion.spin_rad_s + change.segment<3>(6), motion.sticking},
      kStep_s, nullptr);
  return (Eigen::Matrix<double, 6, 1>() << force.force_N, force.friction_N).finished();
}

TEST_CASE("The slopes of a contact are the derivatives of its force", "[contact]") {
  const double before_m = GENERATE(-0.01, 0.0005, 0.004);  // deepening, and letting go
  const Contact contact = GENERATE_COPY(spheres(before_m), plane(before_m));
  const double speed = GENERATE(0.02, 2.0);  // either side of the slip speed
  const ContactMotion motion{at_depth_m(contact, 0.002), speed * Eigen::Vector3d(0.5, -0.7, -0.2),
                             speed * Eigen::Vector3d(3, 5, -8)};
  ContactDerivatives derivatives;
  (void)contact_force(contact, motion, kStep_s, &derivatives);
  NineDerivatives exact, measured;
  exact << derivatives.force_by_position, derivatives.force_by_velocity, derivatives.force_by_spin,
      derivatives.friction_by_position, derivatives.friction_by_velocity,
      derivatives.friction_by_spin;

  constexpr double kChange = 1e-6;
  for (int i = 0; i < 9; ++i) {
    Eigen::Matrix<double, 9, 1> change = Eigen::Matrix<double, 9, 1>::Zero();
    change[i] = kChange;
    measured.col(i) =
        (forces_at(contact, motion, change) - forces_at(contact, motion, -change)) / (2 * kChange);
  }

  for (int block = 0; block < 3; ++block)
    CHECK((measured - exact).middleCols<3>(3 * block).norm() <
          1e-6 * exact.middleCols<3>(3 * block).norm());
}

TEST_CASE("The slopes of a contact that sticks are the derivatives of its force", "[contact]") {
  const Contact contact = GENERATE(spheres(0.0005), plane(0.0005));
  const double slid_m = GENERATE(1e-4, 3e-3);  // it holds; it slides
  const ContactMotion motion{at_depth_m(contact, 0.002),
                             slid_m / kStep_s * Eigen::Vector3d(0.9, 0.1, 0.5),
                             slid_m / kStep_s * Eigen::Vector3d(2, -9, 4),
                             Sticking{slid_m * Eigen::Vector3d(0.3, -0.8, 0.4), kStep_s}};
  ContactDerivatives derivatives;
  const ContactForce force = contact_force(contact, motion, kStep_s, &derivatives);
  REQUIRE((force.friction_N.norm() > (0.4 - 1e-9) * (force.force_N - force.friction_N).norm()) ==
          (slid_m > 1e-3));
  NineDerivatives exact, measured;
  exact << derivatives.force_by_position, derivatives.force_by_velocity, derivatives.force_by_spin,
      derivatives.friction_by_position, derivatives.friction_by_velocity,
      derivatives.friction_by_spin;

  constexpr double kChange = 1e-8;
  for (int i = 0; i < 9; ++i) {
    Eigen::Matrix<double, 9, 1> change = Eigen::Matrix<double, 9, 1>::Zero();
    change[i] = kChange;
    measured.col(i) =
        (forces_at(contact, motion, change) - forces_at(contact, motion, -change)) / (2 * kChange);
  }

  CHECK((measured - exact).norm() < 1e-5 * exact.norm());
  CHECK((measured - exact).rightCols<6>().norm() < 1e-5 * exact.rightCols<6>().norm());
}

TEST_CASE(
    "What sticks holds as a spring, slides at friction times pressure, and never gives energy",
    "[contact]") {
  const Contact contact = plane(0.002);
  const Eigen::Vector3d along = contact.plane_normal.unitOrthogonal();
  const double load_N = 800.0 * 0.002, both_N_per_m = 800.0 + 3.0 / kStep_s;
  double stretch_m = 0.0, held_J = 0.0;
  for (const double way_m : {1e-4, 2e-4, 5e-3, -3e-4, -4e-3, 1e-4, 0.0, 0.0}) {
    const ContactMotion motion{at_depth_m(contact, 0.002),
                               way_m / kStep_s * along,
                               {0, 0, 0},
                               Sticking{stretch_m * along, kStep_s}};
    const ContactForce force = contact_force(contact, motion, kStep_s, nullptr);
    const double would_hold_N = both_N_per_m * way_m + 800.0 * stretch_m;
    const double friction_N = force.friction_N.dot(along);
    CHECK(friction_N == Approx(-std::clamp(would_hold_N, -0.4 * load_N, 0.4 * load_N)));
    stretch_m = force.stretch_m.dot(along);
    const double now_J = 0.5 * 800.0 * stretch_m * stretch_m;
    CHECK(-friction_N * way_m - (now_J - held_J) >= -1e-15);
    held_J = now_J;
  }
}

}  // namespace
}  // namespace stillgrid::contact::contact_test

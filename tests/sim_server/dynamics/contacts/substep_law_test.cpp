#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "sim_server/dynamics/contacts/contact_rows.hpp"
#include "tests/sim_server/dynamics/contacts/scalar_law.hpp"
#include "tests/sim_server/every_target.hpp"

namespace stillgrid::dynamics::substep_law_test {
namespace {

using Eigen::Vector3d;

/// A contact along z with the given depth in the middle.
SubstepContact contact_of(double depth_m, const Vector3d& start_velocity_m_s,
                          const collision::ContactMaterial& material) {
  SubstepContact contact;
  contact.material = material;
  contact.depth_m = depth_m;
  contact.start_velocity_m_s = start_velocity_m_s;
  return contact;
}

Vector3d any_vector(std::mt19937& random, double length) {
  std::uniform_real_distribution<double> one(-length, length);
  return {one(random), one(random), one(random)};
}

TEST_CASE("At rest the force is k times the depth, whatever the substep", "[substep_law]") {
  const double substep_s = GENERATE(1e-5, 1e-3, 0.03);
  const SubstepContact contact =
      contact_of(1.5e-3, Vector3d::Zero(), {.stiffness_N_per_m = 800.0, .damping_N_s_per_m = 3.0});

  const ContactImpulse impulse = contact_impulse(contact, Vector3d::Zero(), substep_s);

  CHECK(impulse.impulse_N_s.z() / substep_s == Approx(1.2).epsilon(1e-14));
  CHECK(impulse.damper_N == 0.0);
}

TEST_CASE("The spring's work is the change of its energy, also where a contact comes or goes",
          "[substep_law]") {
  std::mt19937 random(1);
  constexpr double kSubstep_s = 2e-3;
  int came = 0, went = 0;
  for (int i = 0; i < 10000; ++i) {
    const SubstepContact contact = contact_of(any_vector(random, 1e-3).z(), any_vector(random, 1.0),
                                              {.stiffness_N_per_m = 2e3});
    const Vector3d end_m_s = any_vector(random, 1.0);
    const double start_m = start_depth_m(contact, kSubstep_s);
    const double end_m = end_depth_m(contact, end_m_s, kSubstep_s);
    came += start_m < 0.0 && end_m > 0.0;
    went += start_m > 0.0 && end_m < 0.0;

    const double work_J = contact_impulse(contact, end_m_s, kSubstep_s)
                              .impulse_N_s.dot(0.5 * (contact.start_velocity_m_s + end_m_s));

    CHECK(work_J == Approx(spring_energy_J(contact.material, start_m) -
                           spring_energy_J(contact.material, end_m))
                        .margin(1e-16));
  }
  CHECK(came > 1000);
  CHECK(went > 1000);
}

TEST_CASE("The damper acts while depth grows, over the part that overlaps", "[substep_law]") {
  const collision::ContactMaterial damper{.damping_N_s_per_m = 4.0};
  constexpr double kSubstep_s = 1e-3;
  const auto damping_N = [&](double depth_m, double speed_m_s) {
    return contact_impulse(contact_of(depth_m, {0, 0, speed_m_s}, damper), {0, 0, speed_m_s},
                           kSubstep_s)
        .damper_N;
  };

  CHECK(damping_N(1e-3, -0.2) == Approx(0.8));
  CHECK(damping_N(0.0, -0.2) == Approx(0.4));  // half of the way overlaps
  CHECK(damping_N(1e-3, 0.2) == 0.0);
}

TEST_CASE("Friction holds up to friction times the normal force and gives no energy",
          "[substep_law]") {
  std::mt19937 random(2);
  const collision::ContactMaterial material{
      .stiffness_N_per_m = 2e3, .damping_N_s_per_m = GENERATE(0.0, 5.0), .friction = 0.4};
  for (int i = 0; i < 10000; ++i) {
    const double substep_s = std::pow(10.0, any_vector(random, 1.0).x() - 3.0);
    SubstepContact contact = contact_of(1e-3, Vector3d::Zero(), material);
    contact.stretch_m = any_vector(random, 1e-3);
    contact.stretch_m.z() = 0.0;
    Vector3d slid_m = any_vector(random, 2e-3);
    slid_m.z() = 0.0;
    const double most_N = any_vector(random, 1.0).cwiseAbs().x();

    const contact::StickingForce force =
        contact::sticking_force(contact.material, contact.stretch_m, slid_m, most_N, substep_s);

    CHECK(force.force_N.norm() <= most_N * (1.0 + 1e-12));
    const double held_J = 1e3 * (force.stretch_m.squaredNorm() - contact.stretch_m.squaredNorm());
    CHECK(-force.force_N.dot(slid_m) - held_J >= -1e-15);
  }
}

TEST_CASE("No change of velocity asks for more impulse than the slopes bound", "[substep_law]") {
  std::mt19937 random(3);
  constexpr double kSubstep_s = 1e-3;
  const collision::ContactMaterial material{.stiffness_N_per_m = 2e3, .damping_N_s_per_m = 2.0};
  for (int i = 0; i < 10000; ++i) {
    const SubstepContact contact =
        contact_of(any_vector(random, 1e-3).z(), any_vector(random, 1.0), material);
    const Vector3d one_m_s = any_vector(random, 1.0), other_m_s = any_vector(random, 1.0);
    const ContactImpulse at = contact_impulse(contact, one_m_s, kSubstep_s);
    const double impulse_change_N_s =
        contact_impulse(contact, other_m_s, kSubstep_s).impulse_N_s.z() - at.impulse_N_s.z();
    const double slope_kg = -impulse_change_N_s / (other_m_s.z() - one_m_s.z());
    CHECK(slope_kg >= -1e-12);
    CHECK(slope_kg <= impulse_slopes(contact, at, kSubstep_s).normal_kg * (1.0 + 1e-9));
  }
}

/// Holds rows of random contacts against the scalar law; what they came to.
std::vector<double> check_rows() {
  std::mt19937 random(4);
  std::vector<double> seen;
  constexpr double kSubstep_s = 1.3e-3;
  for (int block = 0; block < 500; ++block) {
    std::vector<ContactPoint> velocities(9);
    std::vector<ContactPush> pushes(8);
    for (std::size_t i = 1; i < 9; ++i) {
      velocities[i].linear.map() = any_vector(random, 0.5);
      velocities[i].angular.map() = any_vector(random, 9.0);
    }
    std::vector<ContactPoint> begin = velocities;
    for (std::size_t i = 1; i < 9; ++i) begin[i].linear.map() += any_vector(random, 0.3);
    std::vector<ContactSphere> spheres(7);
    std::vector<ContactRows> all(1);
    ContactRows& rows = all.front();
    std::vector<ContactImpulse> alone;
    for (std::size_t lane = 0; lane < 7; ++lane) {  // the last stays empty
      SubstepContact contact = contact_of(any_vector(random, 1e-3).z(), Vector3d::Zero(),
                                          {.stiffness_N_per_m = 2e3,
                                           .damping_N_s_per_m = lane % 3 == 0 ? 0.0 : 2.0,
                                           .friction = lane % 4 == 0 ? 0.0 : 0.4,
                                           .slip_speed_m_s = 0.05});
      contact.normal = any_vector(random, 1.0).normalized();
      contact.is_viscous = lane % 2 == 1;
      const Vector3d before = (contact.normal + any_vector(random, 0.05)).normalized();
      const Vector3d stretch_m =
          contact.is_viscous ? Vector3d::Zero() : Vector3d(1e-4 * before.unitOrthogonal());
      rows.a[lane] = static_cast<int>(lane) + 1;
      rows.b[lane] = static_cast<int>(7 - lane);
      rows.sphere_a[lane] = static_cast<int>(lane);
      rows.sphere_b[lane] = -1;
      rows.turns_a[lane] = 1.0;
      rows.radius_m[lane] = 0.02;
      rows.distance_m[lane] = 0.05;
      rows.set_material(lane, contact.material, contact.is_viscous);
      const double far_m = 0.05 - contact.depth_m;
      const Vector3d arm_m = any_vector(random, 0.01), given_m_s = any_vector(random, 0.1);
      spheres[lane].position_m.map() = any_vector(random, 0.3);
      spheres[lane].arm_m.map() = arm_m + 0.4 * far_m * contact.normal;
      rows.other_m[lane].map() = spheres[lane].position_m.map() - far_m * contact.normal;
      ContactRows::set(rows.given_across_m_s, lane, given_m_s);
      ContactRows::set(rows.given_along_m_s, lane, given_m_s);
      ContactRows::set(rows.stretch_m, lane, stretch_m);
      ContactRows::set(rows.normal, lane, before);
      const auto velocity_m_s = [&](const std::vector<ContactPoint>& points) -> Vector3d {
        const ContactPoint& a = points[lane + 1];
        return a.linear.map() + Vector3d(a.angular.map()).cross(arm_m) -
               points[7 - lane].linear.map() - given_m_s;
      };
      const double spin_rad_s =
          contact.normal.dot(begin[lane + 1].angular.map() + begin[7 - lane].angular.map());
      contact.start_velocity_m_s = velocity_m_s(begin);
      contact.stretch_m =
          carried_stretch_m(stretch_m, before, contact.normal, 0.5 * kSubstep_s * spin_rad_s);
      alone.push_back(contact_impulse(contact, velocity_m_s(velocities), kSubstep_s));
    }
    place_rows(all, spheres, begin, kSubstep_s);
    static_cast<void>(evaluate_rows(all, velocities, pushes, kSubstep_s));
    RowFlow flow;
    end_rows(all, velocities, kSubstep_s, flow);
    for (std::size_t lane = 0; lane < 7; ++lane) {
      const Vector3d impulse_N_s = ContactRows::get(rows.impulse_N_s, lane);
      const Vector3d stretch_m = ContactRows::get(rows.stretch_m, lane);
      CHECK((impulse_N_s - alone[lane].impulse_N_s).norm() < 1e-14);
      CHECK(rows.spring_N[lane] == Approx(alone[lane].spring_N).margin(1e-12));
      CHECK(rows.damper_N[lane] == Approx(alone[lane].damper_N).margin(1e-12));
      CHECK((stretch_m - alone[lane].stretch_m).norm() < 1e-15);
      seen.insert(seen.end(), {impulse_N_s.x(), impulse_N_s.y(), impulse_N_s.z(), stretch_m.x(),
                               stretch_m.y(), stretch_m.z()});
    }
    for (std::size_t lane = 0; lane < 8; ++lane) {
      const Vector3d impulse_N_s = pushes[lane].linear.map();
      CHECK(impulse_N_s == ContactRows::get(rows.impulse_N_s, lane));
      const auto moment = [&](const ContactRows::Vector& arm_m) -> Vector3d {
        return ContactRows::get(arm_m, lane).cross(impulse_N_s);
      };
      CHECK((pushes[lane].moment_a.map() - moment(rows.arm_a_m)).norm() < 1e-15);
      CHECK((pushes[lane].moment_b.map() - moment(rows.arm_b_m)).norm() < 1e-15);
    }
    CHECK(ContactRows::get(rows.impulse_N_s, 7).isZero(0.0));
  }
  return seen;
}

TEST_CASE("Rows of eight contacts push as each by itself, to the same bytes on every target",
          "[substep_law]") {
  std::vector<double> first;
  sim_server::on_every_target([&] {
    const std::vector<double> seen = check_rows();
    if (first.empty()) first = seen;
    CHECK(seen == first);
  });
}

TEST_CASE("A stretch turns with its contact and keeps its length", "[substep_law]") {
  const Vector3d carried_m =
      carried_stretch_m({2e-3, 0, 0}, Vector3d::UnitZ(), Vector3d(0.1, 0, 1).normalized(), 0.0);

  CHECK(carried_m.norm() == Approx(2e-3));
  CHECK(carried_m.dot(Vector3d(0.1, 0, 1)) == Approx(0.0).margin(1e-18));
  CHECK(carried_m.y() == Approx(0.0).margin(1e-18));
  const Vector3d twisted_m =
      carried_stretch_m({2e-3, 0, 0}, Vector3d::UnitZ(), Vector3d::UnitZ(), 1e-3);
  CHECK(twisted_m.y() == Approx(2e-6).epsilon(1e-5));
}

}  // namespace
}  // namespace stillgrid::dynamics::substep_law_test

#include "sim_server/dynamics/contacts/contact_core.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/dynamics/contacts/contact_world.hpp"

namespace stillgrid::dynamics::contact_core_test {
namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.01, kMass_kg = 0.02, kNear_m = 0.005;

const collision::ContactMaterial kRubber{
    .stiffness_N_per_m = 500.0, .damping_N_s_per_m = 1.0, .friction = 0.3};

/// A heap of spheres of two sizes that falls on the floor.
ContactWorld heap_of(int count, const collision::ContactMaterial& material,
                     ContactAccuracy accuracy = {}) {
  ContactWorld heap(material, accuracy);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> off(-0.15, 0.15);
  const int side = static_cast<int>(std::ceil(std::cbrt(count)));
  for (int i = 0; i < count; ++i) {
    const Vector3d cell(i % side, i / side % side, i / (side * side));
    const double radius_m = kRadius_m * (i % 3 == 0 ? 0.8 : 1.0);
    heap.add(2.3 * kRadius_m * (cell + Vector3d(off(random), off(random), 0.6)), radius_m,
             kMass_kg * std::pow(radius_m / kRadius_m, 3));
  }
  return heap;
}

ContactSolve run(ContactWorld& world, double duration_s, double substep_s) {
  ContactSolve worst;
  const int substeps = static_cast<int>(std::round(duration_s / substep_s));
  for (int i = 0; i < substeps; ++i) {
    world.find(kNear_m + 2.0 * substep_s * world.fastest_m_s());
    const ContactSolve solve = world.substep(substep_s);
    worst.iterations = std::max(worst.iterations, solve.iterations);
    worst.converged = worst.converged && solve.converged;
  }
  return worst;
}

/// Three balls that roll over each other, far from the heaps of heap_of().
void add_pile(ContactWorld& world) {
  world.add({9.0, 0, kRadius_m}, kRadius_m, kMass_kg);
  world.add({9.002, 0.001, 2.9 * kRadius_m}, 0.9 * kRadius_m, 3.0 * kMass_kg, {0.3, 0, -0.5});
  world.add({9.021, 0, kRadius_m}, kRadius_m, 2.0 * kMass_kg);
}

bool same_motion(const RigidState& a, const RigidState& b) {
  return std::memcmp(a.position_m.data(), b.position_m.data(), sizeof a.position_m) == 0 &&
         std::memcmp(a.velocity_m_s.data(), b.velocity_m_s.data(), sizeof a.velocity_m_s) == 0 &&
         std::memcmp(a.spin_rad_s.data(), b.spin_rad_s.data(), sizeof a.spin_rad_s) == 0;
}

TEST_CASE("A ball lies as deep as its weight presses it, whatever the substep", "[contact_core]") {
  const double substep_s = GENERATE(1e-4, 1e-3, 4e-3, 0.01, 0.03);
  ContactWorld world(kRubber);
  world.add({0, 0, kRadius_m}, kRadius_m, kMass_kg);

  run(world, 20.0, substep_s);

  CHECK(500.0 * (kRadius_m - world.state.rigid[0].position_m.z()) ==
        Approx(9.81 * kMass_kg).epsilon(1e-9));
  CHECK(world.fastest_m_s() < 1e-9);
}

TEST_CASE("Ten balls on each other are as deep as what they bear", "[contact_core]") {
  const double substep_s = GENERATE(1e-3, 5e-3);
  collision::ContactMaterial stiff{.stiffness_N_per_m = 5000.0, .damping_N_s_per_m = 100.0};
  ContactWorld world(stiff);
  for (int i = 0; i < 10; ++i) world.add({0, 0, (2 * i + 1) * kRadius_m}, kRadius_m, 0.1);

  const ContactSolve solve = run(world, 8.0, substep_s);

  CHECK(solve.converged);
  double below_m = -kRadius_m;
  for (int i = 0; i < 10; ++i) {
    const double height_m = world.state.rigid[static_cast<std::size_t>(i)].position_m.z();
    CHECK(2.0 * kRadius_m - (height_m - below_m) ==
          Approx((10 - i) * 0.981 / 5000.0).epsilon(1e-6));
    below_m = height_m;
  }
}

TEST_CASE("A bounce without damper keeps its energy, whatever the substep", "[contact_core]") {
  const double substep_s = GENERATE(1e-4, 1e-3, 3e-3, 0.01);
  ContactWorld world({.stiffness_N_per_m = 1000.0}, {.relative = 1e-9});
  world.add({0, 0, 0.05}, kRadius_m, 0.1);
  const double start_J = world.gravity_J();

  double most_J = start_J, least_J = start_J;
  for (int i = 0; i < 20.0 / substep_s; ++i) {
    world.find(1.0);
    world.substep(substep_s);
    const double energy_J = world.kinetic_J() + world.gravity_J() + world.overlaps_J();
    most_J = std::max(most_J, energy_J);
    least_J = std::min(least_J, energy_J);
  }

  CHECK(most_J - start_J < 1e-9 * start_J);
  CHECK(start_J - least_J < 1e-9 * start_J);
}

TEST_CASE("The approach damper's restitution is exp(-zeta / q acos zeta), to second order",
          "[contact_core]") {
  // Case 3.10: zeta .2 gives .756135.
  const auto restitution = [](double substep_s) {
    const double damping = 2.0 * 0.2 * std::sqrt(1000.0 * 0.1);
    ContactWorld world({.stiffness_N_per_m = 1000.0, .damping_N_s_per_m = damping});
    world.world.gravity_m_s2.setZero();
    world.add({0, 0, kRadius_m + 1e-3}, kRadius_m, 0.1, {0, 0, -1.0});
    for (int i = 0; i < 0.2 / substep_s; ++i) {
      world.find(1.0);
      world.substep(substep_s);
    }
    return world.state.rigid[0].velocity_m_s.z();
  };
  CHECK(restitution(1e-3) == Approx(0.756135).epsilon(0.01));
  CHECK(restitution(1e-4) == Approx(0.756135).epsilon(5e-4));
}

TEST_CASE("Whatever the list's order, the same bytes", "[contact_core]") {
  ContactWorld one = heap_of(200, kRubber), other = heap_of(200, kRubber);
  other.shuffles = true;

  run(one, 0.5, 1e-3);
  run(other, 0.5, 1e-3);

  for (std::size_t i = 0; i < one.state.rigid.size(); ++i) {
    CHECK(same_motion(one.state.rigid[i], other.state.rigid[i]));
  }
}

TEST_CASE("What does not touch changes no byte of each other's motion", "[contact_core]") {
  ContactWorld both = heap_of(100, kRubber), heap = heap_of(100, kRubber), pile(kRubber);
  add_pile(both);
  add_pile(pile);
  for (int i = 0; i < 800; ++i)
    for (ContactWorld* world : {&both, &heap, &pile}) {
      world->find(0.03);
      world->substep(1e-3);
    }
  CHECK(heap.core.touching() > 90);
  for (std::size_t i = 0; i < heap.state.rigid.size(); ++i)
    CHECK(same_motion(both.state.rigid[i], heap.state.rigid[i]));
  for (std::size_t i = 0; i < pile.state.rigid.size(); ++i)
    CHECK(same_motion(both.state.rigid[heap.state.rigid.size() + i], pile.state.rigid[i]));
}

TEST_CASE("A part that is thrown away leaves no trace", "[contact_core]") {
  ContactWorld straight = heap_of(60, kRubber);
  run(straight, 0.4, 1e-3);
  ContactWorld other = straight;
  for (int i = 0; i < 20; ++i) {
    const ExplicitState before = other.state;
    other.keeps = false;
    other.find(kNear_m);
    other.substep(3e-3);
    other.keeps = true;
    other.state = before;
    for (ContactWorld* world : {&straight, &other}) {
      world->find(kNear_m);
      world->substep(1e-3);
    }
  }
  CHECK(straight.core.stretch_energy_J() > 0.0);
  CHECK(other.core.stretch_energy_J() == straight.core.stretch_energy_J());
  for (std::size_t i = 0; i < straight.state.rigid.size(); ++i)
    CHECK(same_motion(straight.state.rigid[i], other.state.rigid[i]));
}

TEST_CASE("Pairs that lie still stay stretched on no list, those that part do not",
          "[contact_core]") {
  ContactWorld world(kRubber);
  world.add({0, 0, kRadius_m}, kRadius_m, kMass_kg);
  world.add({1, 0, kRadius_m}, kRadius_m, kMass_kg);
  world.world.gravity_m_s2 = {1.0, 0.0, -9.81};
  run(world, 0.01, 1e-3);
  const double held_J = world.core.stretch_energy_J(), friction_J = world.flow.friction_J;
  REQUIRE(held_J > 0.0);
  const auto list_none = [&] {
    world.contacts.clear();
    world.substep(1e-3);
    return world.core.stretch_energy_J();
  };
  world.world.rigid_bodies[0].unknown = bodies::kNoUnknown;
  CHECK(list_none() == Approx(0.5 * held_J).epsilon(1e-6));
  world.world.rigid_bodies[0].unknown = 0;
  CHECK(list_none() == 0.0);
  CHECK(world.flow.friction_J - friction_J == Approx(held_J).epsilon(1e-6));
}

TEST_CASE("Whatever the bodies' order, the same motion to rounding, however few the iterations",
          "[contact_core]") {
  const ContactAccuracy accuracy{.relative = 0.0, .most_iterations = GENERATE(2, 5)};
  ContactWorld one = heap_of(60, kRubber, accuracy);
  ContactWorld other(kRubber, accuracy);
  for (std::size_t i = one.state.rigid.size(); i-- > 0;)
    other.add(one.state.rigid[i].position_m, one.world.spheres[i].radius_m,
              1.0 / one.state.rigid[i].inverse_mass_per_kg);

  run(one, 0.05, 1e-3);
  run(other, 0.05, 1e-3);

  double most_m = 0.0;
  const std::size_t count = one.state.rigid.size();
  for (std::size_t i = 0; i < count; ++i)
    most_m = std::max(
        most_m,
        (one.state.rigid[i].position_m - other.state.rigid[count - 1 - i].position_m).norm());
  CHECK(one.core.touching() > 30);
  CHECK(most_m < 1e-11);
}

TEST_CASE("Momentum and spin are kept to rounding, though iterations end early", "[contact_core]") {
  ContactWorld world = heap_of(60, kRubber, {.most_iterations = 1});
  world.planes.clear();
  world.world.gravity_m_s2.setZero();
  for (RigidState& body : world.state.rigid) body.velocity_m_s = -3.0 * body.position_m;
  const auto momenta = [&] {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (const RigidState& body : world.state.rigid) {
      const Vector3d own = body.velocity_m_s / body.inverse_mass_per_kg;
      sum.head<3>() += own;
      sum.tail<3>() += body.position_m.cross(own) + body.angular_momentum_N_m_s;
    }
    return sum;
  };
  const auto start = momenta();

  run(world, 0.2, 1e-3);

  CHECK(world.flow.contact_damping_J > 1e-3);
  CHECK((momenta() - start).norm() < 1e-12);
}

TEST_CASE("The account closes to rounding in every substep, and no energy is made",
          "[contact_core]") {
  const collision::ContactMaterial material{.stiffness_N_per_m = GENERATE(500.0, 2e4),
                                            .damping_N_s_per_m = GENERATE(0.0, 1.0),
                                            .friction = GENERATE(0.0, 0.5)};
  const double substep_s = GENERATE(2e-4, 2e-3);
  ContactWorld heap = heap_of(100, material);
  const double start_J = heap.gravity_J() + heap.overlaps_J();
  double worst_J = 0.0, most_J = 0.0;
  for (int i = 0; i < 1.0 / substep_s; ++i) {
    heap.find(kNear_m + 2.0 * substep_s * heap.fastest_m_s());
    const double before_J = heap.kinetic_J() + heap.gravity_J() + heap.core.stretch_energy_J();
    const EnergyFlow flow = heap.flow;
    const double unsolved_J = heap.flow.unsolved_J;
    heap.substep(substep_s);
    const double after_J = heap.kinetic_J() + heap.gravity_J() + heap.core.stretch_energy_J();
    const double lost_J = heap.flow.contact_damping_J - flow.contact_damping_J +
                          heap.flow.friction_J - flow.friction_J;
    // What springs of contacts took: their energy as the substep sees it, and what is left undone.
    const double taken_J = heap.core.spring_change_J() - (heap.flow.unsolved_J - unsolved_J);
    worst_J = std::max(worst_J, std::abs(after_J - before_J + lost_J + taken_J));
    most_J = std::max(most_J, after_J + heap.overlaps_J());
  }
  CHECK(worst_J < 1e-12 * start_J);
  // Normals turn within a substep, which is of second order and here as long as a bounce.
  CHECK(most_J < start_J * 1.02);
  CHECK(heap.flow.friction_J >= -1e-12 * start_J);
  CHECK(heap.flow.contact_damping_J >= 0.0);
}

TEST_CASE("A heap of 1,000 spheres in a trough comes to rest", "[contact_core]") {
  ContactWorld heap = heap_of(1000 / tests::kCut, kRubber);
  heap.planes.clear();
  for (const Vector3d& side :
       {Vector3d(1, 0, 1), Vector3d(-1, 0, 1), Vector3d(0, 1, 1), Vector3d(0, -1, 1)})
    heap.planes.push_back(side.normalized());
  for (RigidState& body : heap.state.rigid) body.position_m += Vector3d(-0.115, -0.115, 0.13);

  const ContactSolve solve = run(heap, 15.0, 2e-3);

  CHECK(solve.converged);
  const double friction_J = heap.flow.friction_J;
  CHECK(heap.fastest_m_s() < 1e-5);
  run(heap, 1.0, 2e-3);
  CHECK(std::abs(heap.flow.friction_J - friction_J) < 1e-9);
}

TEST_CASE("Soft on stiff: each as deep as its own stiffness says", "[contact_core]") {
  ContactWorld world(kRubber);
  world.add({0, 0, kRadius_m}, kRadius_m, kMass_kg);
  world.add({0, 0, 3 * kRadius_m}, kRadius_m, kMass_kg);
  for (int i = 0; i < 4000; ++i) {
    world.find(1.0);
    for (contact::Contact& contact : world.contacts)
      if (contact.is_plane)
        contact.material = {.stiffness_N_per_m = 1e6, .damping_N_s_per_m = 30.0, .friction = 0.3};
    world.substep(1e-3);
  }
  const double low_m = world.state.rigid[0].position_m.z(),
               high_m = world.state.rigid[1].position_m.z();
  CHECK(kRadius_m - low_m == Approx(2 * 9.81 * kMass_kg / 1e6).epsilon(1e-6));
  CHECK(2 * kRadius_m - (high_m - low_m) == Approx(9.81 * kMass_kg / 500.0).epsilon(1e-6));
}

TEST_CASE("A thousand times heavier above or below, both lie still", "[contact_core]") {
  const bool heavy_above = GENERATE(false, true);
  ContactWorld world({.stiffness_N_per_m = 2e4, .damping_N_s_per_m = 200.0, .friction = 0.3});
  const double light_kg = 0.005, heavy_kg = 5.0;
  world.add({0, 0, kRadius_m}, kRadius_m, heavy_above ? light_kg : heavy_kg);
  world.add({0, 0, 3 * kRadius_m}, kRadius_m, heavy_above ? heavy_kg : light_kg);

  const ContactSolve solve = run(world, 10.0, 1e-3);

  CHECK(solve.converged);
  const double low_m = world.state.rigid[0].position_m.z(),
               high_m = world.state.rigid[1].position_m.z();
  CHECK(kRadius_m - low_m == Approx((light_kg + heavy_kg) * 9.81 / 2e4).epsilon(1e-6));
  CHECK(2 * kRadius_m - (high_m - low_m) ==
        Approx((heavy_above ? heavy_kg : light_kg) * 9.81 / 2e4).epsilon(1e-6));
  CHECK(world.fastest_m_s() < 1e-9);
}

TEST_CASE("Each iteration comes nearer, and Chebyshev's weights come nearer faster",
          "[contact_core]") {
  ContactWorld heap =
      heap_of(300, {.stiffness_N_per_m = 2e4, .damping_N_s_per_m = 1.0, .friction = 0.3});
  run(heap, 0.4, 1e-3);
  double before = 1e300;
  for (const int iterations : {1, 4, 8, 16, 32}) {
    ContactWorld copy = heap;
    copy.core.set_accuracy({.relative = 0.0, .most_iterations = iterations});
    copy.find(kNear_m);
    const double left = copy.substep(2e-3).residual_m_s;
    CHECK(left < before);
    before = left;
  }
}

}  // namespace
}  // namespace stillgrid::dynamics::contact_core_test

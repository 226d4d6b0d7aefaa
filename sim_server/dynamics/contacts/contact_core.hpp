#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/dynamics/contacts/contact_list.hpp"
#include "sim_server/dynamics/contacts/contact_movers.hpp"
#include "sim_server/dynamics/contacts/contact_rows.hpp"
#include "sim_server/dynamics/forces/explicit_state.hpp"
#include "sim_server/dynamics/forces/trial.hpp"
#include "sim_server/dynamics/solvers/budget.hpp"
#include "sim_server/dynamics/workers/workers.hpp"

namespace stillgrid::dynamics {

/// How far the solution of a substep's contacts goes. Relative to what changes in the substep: what
/// is left then shrinks with the motion, so that a scene comes to rest, and scales with its units.
struct ContactAccuracy {
  double relative = 0.1;  // of the largest change of velocity in the substep
  int most_iterations = 200;
};

/// How it ended, of the island where it ended worst.
struct ContactSolve {
  int iterations = 0;
  double residual_m_s = 0.0;     // what an impulse more would still change of a velocity, at most
  double stiffness_ratio = 0.0;  // h^2 omega^2 / 2 of the contact springs of the stiffest body, at
                                 // most
  bool converged = true;
  bool late = false;  // so that it ended early

  void add(const ContactSolve& more);
};

/// The contacts of explicit integrators, held implicitly: they limit no substep.
///
/// Velocities of a substep solve M (v' - v) = impulses of all else + J^T p(v'), p being those of
/// ContactRows. With contacts alone in p the substep is limited by the rest's stiffness only:
/// for linear contacts v' - v follows Verlet with masses M + h^2 K_contacts / 4, and
/// 4 (M + h^2 K_contacts / 4) / h^2 - K_rest - K_contacts > 0 is 4 M / h^2 > K_rest.
///
/// The equations are solved by Jacobi iterations over bodies, each body's block being bounded from
/// above so that every iteration comes nearer, with Chebyshev's weights [Golub, Varga 1961]. All
/// bodies move at once: no order of contacts or bodies matters, but for rounding, however few
/// iterations there are, and none at all for the order of the list: sums go by spheres' numbers.
/// Islands, of bodies that touch, are solved one after another: what an island does depends on no
/// other, to the bit. The impulses applied are those of the last iteration, each on both sides:
/// momentum is kept to rounding. Nothing but stretches lasts from substep to substep, so that there
/// is no other state.
///
/// Nothing is allocated once there was room.
class ContactCore {
 public:
  explicit ContactCore(ContactAccuracy accuracy = {}) : accuracy_(accuracy) {}

  /// Who shares the work of large islands; must outlive this. No byte depends on it.
  void share_work(const Workers& workers) { workers_ = &workers; }
  /// Takes the contacts of a part of a step: see ContactList. Stretches begin as they were kept.
  void take(const bodies::World& world, std::span<const contact::Contact> contacts);
  /// The part counts: its stretches are what the next begins with.
  void keep();

  /// Finds what touches within a substep. Pre: the state's positions are those of the substep's
  /// middle, at that share of the part, and its velocities those of its
  /// start, its forces those of springs.
  void begin(double share, double part_s, double substep_s, const Eigen::Vector3d& gravity_m_s2,
             const ExplicitState& state);

  /// Leads the state's velocities, which all else has changed, to the substep's end. Adds what
  /// contacts take and are given. Pre: begin() of the same substep.
  ContactSolve solve(double substep_s, const Budget& budget, ExplicitState& state,
                     EnergyFlow& flow);

  [[nodiscard]] bool struck() const noexcept { return struck_; }
  [[nodiscard]] std::size_t touching() const noexcept { return near_.size(); }
  /// That overlap where the state is.
  [[nodiscard]] int count_touching(const ExplicitState& state) {
    return list_.count_touching(state, workers());
  }
  /// What sticks holds that, of what was kept.
  [[nodiscard]] ContactMemories& memories() noexcept { return list_.memories(); }
  [[nodiscard]] double stretch_energy_J() const { return list_.memories().energy_J(); }
  /// In the last substep, J: what the contacts' springs hold more at its end than at its start.
  [[nodiscard]] double spring_change_J() const noexcept { return spring_change_J_; }
  void set_accuracy(const ContactAccuracy& accuracy) noexcept { accuracy_ = accuracy; }
  /// Fastest approach in smaller radii a second, of pairs of spheres.
  [[nodiscard]] double approach_per_s(const ExplicitState& state, double part_s) const {
    return list_.approach_per_s(state, part_s);
  }

 private:
  static constexpr std::size_t kRowsAChunk = 64;  // that one thread takes at once
  /// A pair, and its lane.
  struct Given {
    std::size_t pair, place;
  };

  void divide(const ExplicitState& state);
  void fill_lane(std::size_t index, std::size_t place);
  void set_field_material(std::size_t index, std::size_t place, double before_N_per_m);
  void place_given(double share, double part_s, const ExplicitState& state);
  void keep_stretches();
  /// Those who share the work of as many rows as there are.
  [[nodiscard]] const Workers& workers() const noexcept;
  ContactSolve solve_island(const ContactIsland& island, double substep_s, const Budget& budget,
                            ExplicitState& state, const Workers& workers);
  [[nodiscard]] bool evaluate(const ContactIsland& island, double substep_s,
                              const Workers& workers);
  void end(double substep_s, EnergyFlow& flow);

  ContactAccuracy accuracy_;
  ContactList list_;
  ContactMovers movers_;
  const Workers* workers_ = &Workers::alone();
  std::vector<char> is_near_;                // of each pair
  std::vector<std::size_t> near_, nearer_;   // pairs that may touch, in the last substep and now
  std::vector<std::size_t> place_of_;        // where each is among the touches
  std::vector<std::size_t> sorted_, lanes_;  // of touches: pair, and lane after lane of rows_
  std::vector<int> moved_;                   // of each of them one that it moves, or -1
  std::vector<ContactRows> rows_;            // each island begins one, in an island by key
  std::vector<ContactPush> pushes_;          // of each lane
  std::vector<RowFlow> flows_;               // of chunks of rows
  std::vector<ContactSolve> solves_;         // of islands
  std::vector<Given> given_, touch_lanes_;   // of which a side is given; of fields
  double spring_change_J_ = 0.0;
  bool is_divided_ = false, struck_ = false;
};

}  // namespace stillgrid::dynamics

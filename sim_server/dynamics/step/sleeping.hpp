#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/crossing.hpp"

namespace stillgrid::dynamics {

/// Lets free bodies that are at rest sleep: they leave the work of a step, not the snapshot, and
/// stay where they are to the bit until something touches them (docs/algorithms/sleeping.md).
///
/// A body is at rest while its fastest point is slower than its rest_speed_m_s(). Bodies that touch
/// each other or are joined are an island: they sleep once all of them have been at rest for
/// kRest_s, and wake together. The tool, or a prescribed body that moves, keeps what touches it or
/// is joined to it awake.
class Sleeping {
 public:
  /// How long a body is at rest before it sleeps.
  static constexpr double kRest_s = 0.5;

  explicit Sleeping(const bodies::World& world);

  /// Slower than this a body is at rest: 3 % of its smallest sphere's radius a second, or of its
  /// field's fine cell, and at most
  /// a fifth of its material's slip speed, for what friction lets creep is motion.
  [[nodiscard]] double rest_speed_m_s(int body) const;

  /// Wakes every island with a sphere that would be touched on these ways. True if one woke: its
  /// contacts are yet to be found, and the unknowns are numbered anew.
  bool wake_touched(bodies::World& world, std::span<const contact::Contact> contacts,
                    const contact::Ways& ways);

  /// Takes note of a step's end, spheres being there and contacts all that may touch. If an island
  /// went to sleep, its velocities are now zero and the unknowns numbered anew: returns the kinetic
  /// energy that took. is_sure: the step converged; one that did not tells of no rest.
  std::optional<double> settle(bodies::World& world, std::span<const contact::Contact> contacts,
                               std::span<const bodies::SphereMotion> spheres, double step_s,
                               bool is_sure);

  /// Spheres of all that is sleeping.
  [[nodiscard]] int sleeping_spheres() const noexcept { return sleeping_spheres_; }

 private:
  bool note_speeds(const bodies::World& world, double step_s, bool is_sure);
  void join_islands(const bodies::World& world, std::span<const contact::Contact> contacts,
                    std::span<const bodies::SphereMotion> spheres);
  void lay_down(bodies::World& world, std::size_t body);
  std::size_t root(std::size_t body);

  // Of each body.
  std::vector<double> rest_speed_m_s_;  // zero: it does not sleep
  std::vector<bool> is_fixture_;        // prescribed to stay
  std::vector<double> rested_s_;
  std::vector<std::size_t> parent_;  // towards its island's representative
  std::vector<bool> is_restless_;    // of a representative: something of the island must not sleep
  std::vector<std::size_t> island_;  // that a sleeping body went to sleep with

  int sleeping_spheres_ = 0;
};

}  // namespace stillgrid::dynamics

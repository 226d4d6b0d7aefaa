#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "shared/dynamics/contact_listing.hpp"
#include "shared/dynamics/description.hpp"
#include "shared/dynamics/scene_state.hpp"

namespace stillgrid::dynamics {

/// Lets bodies at rest sleep: a tick leaves them as they are, to the bit, until something would
/// touch them (docs/algorithms/sleeping.md).
///
/// A body is at rest while its fastest point is slower than its rest_speed_m_s. Bodies that touch
/// or that a joint holds are an island. An island sleeps when all its bodies have been at rest for
/// kRest_s, and wakes as one. A driven body that is no fixture keeps awake the bodies that it
/// touches or holds.
///
/// Thread: one. Realtime: never allocates after construction, locks or throws.
class Sleep {
 public:
  static constexpr double kRest_s = 0.5;

  explicit Sleep(const Description& description);

  /// All that later ticks depend on, for a saved state.
  struct Saved {
    std::vector<double> rested_s;      // bodies
    std::vector<std::int32_t> island;  // bodies; -1: awake
  };
  [[nodiscard]] const Saved& saved() const noexcept { return saved_; }
  /// Throws std::invalid_argument where the numbers cannot be those of this Description.
  void check(const Saved& saved) const;
  /// Pre: check(saved).
  void load(const Saved& saved);

  /// Notes the end of a tick. Stops islands that begin to sleep; returns whether one did.
  bool settle(SceneState& state, const ContactListing& listing, const ContactBodies& bodies,
              double tick_s);
  /// Wakes the islands of all sleeping bodies that a sphere awake would touch in the tick. Returns
  /// whether one woke.
  bool wake_touched(const SceneState& state, const ContactListing& listing, double tick_s);
  void wake_all();

  [[nodiscard]] bool is_sleeping(std::size_t body) const { return saved_.island[body] >= 0; }
  [[nodiscard]] std::size_t sleeping() const noexcept { return sleeping_; }
  /// Whether only driven bodies move.
  [[nodiscard]] bool all_sleep() const noexcept {
    return sleeping_ > 0 && sleeping_ == description_.bodies.size() && !has_restless_;
  }
  /// 1: it sleeps.
  [[nodiscard]] std::span<const std::uint8_t> nodes() const noexcept { return node_sleeps_; }
  [[nodiscard]] std::span<const std::uint8_t> rigid_bodies() const noexcept {
    return rigid_sleeps_;
  }
  [[nodiscard]] std::span<const std::uint8_t> spheres() const noexcept { return sphere_sleeps_; }
  /// Kinetic energy of all that began to sleep in the last settle(), J.
  [[nodiscard]] double loss_J() const noexcept { return loss_J_; }

 private:
  /// Wakes the island of a body, if it sleeps. -1: the body never sleeps.
  bool wake(std::int32_t body);
  bool note_speeds(const SceneState& state, double tick_s);
  void join_contacts(const ContactListing& listing, const ContactBodies& bodies);
  void join_joints();
  void join(std::int32_t body, std::int32_t other);
  /// The body of side b of a lane that is no plane; -1: it never sleeps.
  [[nodiscard]] std::int32_t other_body(const ContactListing& listing, std::int32_t sphere_b) const;
  void disturb(std::int32_t body) { is_restless_[static_cast<std::size_t>(root(body))] = 1; }
  std::int32_t root(std::int32_t body);
  void lay_down(std::size_t body, SceneState& state);
  void mark(std::size_t body, std::uint8_t sleeps);
  [[nodiscard]] double kinetic_energy_J(std::size_t body, const SceneState& state) const;

  const Description& description_;
  std::vector<std::int32_t> body_of_node_, body_of_rigid_, body_of_sphere_;  // -1: never sleeps
  std::vector<std::vector<std::int32_t>> spheres_of_body_;
  std::vector<std::pair<std::int32_t, std::int32_t>> sprung_;  // bodies with a spring between them
  bool has_restless_ = false;  // free nodes or rigid bodies that never sleep
  Saved saved_;
  std::vector<std::int32_t> parent_;
  std::vector<std::uint8_t> is_restless_;  // root: some body of the island must not sleep
  std::vector<std::uint8_t> node_sleeps_, rigid_sleeps_, sphere_sleeps_;
  std::size_t sleeping_ = 0;  // bodies
  double loss_J_ = 0.0;
};

/// Writes the joints of which neither end sleeps. Realtime: allocates while there are more than
/// ever before.
void find_awake_joints(const Description& description, const Sleep& sleep,
                       std::vector<Description::Joint>& joints);

}  // namespace stillgrid::dynamics

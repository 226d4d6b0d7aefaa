#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "haptic_server/safety/energy_observer.hpp"
#include "haptic_server/safety/wrench.hpp"

namespace stillgrid::safety {

/// What a tick rendered of a scene. The scene's axes and lengths.
struct RenderedScene {
  std::uint64_t epoch = 0;         // of the scene's segment; another one: another account
  std::uint64_t snapshot_id = 0;   // of the snapshot shown, 0: none
  bool can_move = false;           // anything in it
  std::uint64_t tool_time_ns = 0;  // of the tick whose tool it was computed with, 0: none
  double tool_work_J = 0.0;        // that the simulation booked up to then, from the tool
  Wrench rendered = {};            // on the hand, before any limit
  double stiffness_N_per_m = 0.0;  // of its contacts, together
  double static_J = 0.0;           // that their springs hold against what never moves
  double scale = 1.0;              // of its lengths to the device's
};

/// Energy across the interface of one scene, from the first snapshot of it that was shown, J.
struct InterfaceEnergy {
  double given_by_hand_J = 0.0;  // against the rendered force, up to now
  double booked_J = 0.0;         // by the simulation, up to the newest snapshot's tool
  double held_J = 0.0;           // by springs of static contacts, now
  // Booked and held less given by the hand, up to that tool; negative also by what dampers and
  // friction of static contacts took.
  double made_J = 0.0;
  double in_flight_J = 0.0;    // given by the hand since then, and not held
  double uncertainty_J = 0.0;  // of what was made, either way
  // Of what was made, by white noise of the measured positions alone: no hand felt it.
  double noise_J = 0.0;
  // The most made in any second or longer; none: it has not lasted a second.
  std::optional<double> most_made_in_a_second_J;
};

/// Joins both sides' accounts of what the hand and a scene gave each other.
///
/// The hand's work is that of the rendered force that was held from the tick before to this one.
/// The simulation's is joined to it at the tick whose tool it contains: made = booked + held -
/// given by the hand, all up to that tick. Held is what springs of static contacts hold, which only
/// this side knows: over a wall the leak of a held force is made, less what dampers and friction of
/// static contacts took, which no row tells.
/// docs/algorithms/energy.md.
///
/// Uncertain is what was given and not held since that tick, and what the springs of contacts with
/// what moves held then or hold now, F^2 / 2 k: they may be with one side and not yet with the
/// other. Where nothing can move both sides are of one time, and nothing is uncertain.
///
/// Noise. A force that answers a measured position at once holds its error while the next position
/// is measured without it: every tick makes h s^2, where h is the force's answer to that position,
/// N/m, and s the noise's deviation. The hand was not there. What white noise made is told by the
/// forces of the last three ticks less each other, (f1 - 2 f2 + f3) over the next motion: older
/// forces know nothing of the newest errors, and of a smooth motion they give what f1 gives.
///
/// A snapshot that cannot be true, as of a tick that is yet to come or with work that is no number,
/// ends the account of its scene: it is not known. Thread: the haptic loop's. Realtime: yes.
class InterfaceAccount {
 public:
  /// period_s: of the ticks. Snapshots are joined whose tool is up to four seconds old.
  explicit InterfaceAccount(double period_s);

  /// Books a tick. motion: of the tool since the tick before. Pre: now_ns is later than in the tick
  /// before.
  void note(std::uint64_t now_ns, const DeviceMotion& motion, const RenderedScene& scene) noexcept;

  /// None: no snapshot was joined yet, or one could not be true.
  [[nodiscard]] std::optional<InterfaceEnergy> energy() const noexcept;

  /// What scenes may have given the hand in the run, in the device's scale: what a simulation says
  /// that the tool took, with the uncertainty, as far as it is known. Control of the energy leaves
  /// that to the hand.
  [[nodiscard]] double given_by_scenes_J() const noexcept;

 private:
  struct Tick {
    std::uint64_t time_ns;
    double given_J;   // up to it, by the hand
    double held_J;    // at it, by static contacts,
    double stored_J;  // and by others
    double noise_J;   // up to it, by noise of positions
    double made_J;    // where a snapshot was joined; else no number
  };

  void begin(const RenderedScene& scene) noexcept;
  void push(const Tick& tick) noexcept;
  void join(std::uint64_t tool_time_ns, double tool_work_J) noexcept;
  [[nodiscard]] Tick* tick_at(std::uint64_t time_ns) noexcept;
  [[nodiscard]] Tick& at(std::uint64_t number) noexcept { return ring_[number % ring_.size()]; }
  void age() noexcept;

  std::vector<Tick> ring_;
  std::uint64_t first_ = 0, end_ = 0;  // of the ticks that it holds, by number
  std::uint64_t young_ = 0;            // the first that is not a second older than the last joined
  std::uint64_t epoch_ = 0, snapshot_id_ = 0;
  bool is_known_ = false, is_refused_ = false, can_move_ = false;
  std::array<Wrench, 3> held_;  // of the ticks before, the last one first
  double given_J_ = 0.0, noise_J_ = 0.0, booked_before_J_ = 0.0, scale_ = 1.0;
  double given_by_earlier_J_ = 0.0;  // scenes, in the device's scale
  Tick joined_{}, last_{};
  double least_made_J_ = std::numeric_limits<double>::infinity();  // more than a second ago
  InterfaceEnergy energy_;
};

}  // namespace stillgrid::safety

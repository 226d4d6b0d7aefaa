#pragma once

#include <functional>
#include <optional>
#include <string>

#include "tests/laboratory/fit_run/fit_candidate.hpp"
#include "tests/laboratory/fit_run/fit_reference.hpp"

namespace stillgrid::fit_run {

/// What of a hand's swing where it presses hardest: of the worst press that was tested.
struct FitStability {
  std::optional<bool> stable;  // none: not tested, for the hand touched nothing in the end
  double swing_m = 0.0;        // to and fro, peak to peak
  std::optional<double> reference_swing_m;  // of a scene that moves by itself; none: not needed
  double contact_share = 0.0;               // of the last half second
};

/// The scene of a reference by its own method, made when it is first asked for.
using GivenScene = std::function<const scene::SceneDescription&()>;

/// Whether a hand with the device comes to rest at each of the reference's presses, in closed loop.
///
/// The world begins as the reference had it a second before the press or more, and the tool 2 cm
/// outside, where the force pushes it; it comes to the path, follows it to the press and stays 1.5
/// s: `phantom` of that profile with a light hand and the limits that it declares; its readings are
/// off by up to half an encoder step. The hand means to go deeper than the path, by as much as its
/// spring and the device's friction need to bear the reference's force there. A press without a
/// contact in the last half second proves nothing, unless the reference's method, held likewise,
/// has one: then the hand lost what it pressed, and is unstable.
///
/// What goes to and fro in the last half second, from peak to peak, is an oscillation where it
/// exceeds four encoder steps (docs/cases.md, section 5, but for a drift in contact, as of a body
/// that gives way) and twice what the scene moves the hand by itself: the less of the swing of the
/// reference's method, held likewise, and of how far its force, on a tool that is held fast at the
/// press, moves the hand's spring. So a loop that swings in a scene that stands still has no excuse
/// in a reference that swings too. A drift must not exceed twice the reference's, of its last
/// second.
class HeldPresses {
 public:
  static constexpr int kSeeds = 8;

  /// What is given lives longer. Pre: phantom_profile(profile).
  HeldPresses(const FitCandidate& candidate, double latency_share, const FitReference& reference,
              GivenScene given, std::string profile);

  /// All contact stiffnesses times `margin`; the worst of kSeeds seeds of the readings. Throws as
  /// run_lab(), and CannotStart.
  [[nodiscard]] FitStability at(double margin) const;

  /// The largest margin of 1, 1.26, 1.59, 2, ... 16, thirds of an octave, up to which it holds;
  /// none where it does not hold at 1, or was not tested.
  [[nodiscard]] std::optional<double> largest_margin() const;

 private:
  [[nodiscard]] FitStability at_seed(double margin, int seed) const;
  [[nodiscard]] double own_swing_m(const ReferencePress& press, double margin, int seed) const;

  const FitCandidate& candidate_;
  double latency_share_;
  const FitReference& reference_;
  GivenScene given_;
  std::string profile_;
  double limit_m_;
};

}  // namespace stillgrid::fit_run

#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "tests/laboratory/two_rate_laws.hpp"

/// Exact linear analysis of two coupled rates: a device at 1 kHz, a body that reacts once a period,
/// a contact spring between them that never parts (bilateral). The loop is stable when no
/// eigenvalue of its monodromy matrix, one period's map of the state, lies outside the unit circle.
namespace stillgrid::laboratory::two_rate {

/// The device with what holds it: m x'' + b x' + k x = force, the force held over a tick.
struct Device {
  double mass_kg = 0.1;
  double damping_N_s_per_m = 5.0;
  double hand_N_per_m = 100.0;
};

/// The light device, and the same in the hand that was measured (docs/cases.md, cases 1.13, 1.14).
inline constexpr Device kLightDevice{0.1, 5.0, 100.0};
inline constexpr Device kDeviceInHand{0.654, 7.45, 135.0};

/// One tick of the device, exactly: (x, v)' = transition (x, v) + input force.
struct HeldTick {
  Eigen::Matrix2d transition;
  Eigen::Vector2d input;
};
[[nodiscard]] HeldTick held_tick(const Device& device);

/// Masses in a row. The tool touches the first; a link follows each, the last link's far end is
/// fixed. One mass with a link of no stiffness is a free body.
struct Body {
  int masses = 1;
  double mass_kg = 0.1;       // of each
  double link_N_per_m = 0.0;  // of each
};

/// The bodies over which the worst is sought: free ones of 0.05 to 5 kg, and chains of ten masses
/// of 1 g and 10 g, which bracket what a tool touches of a thread.
[[nodiscard]] std::vector<Body> reacting_bodies();

/// Device and body with the display between them. cycle.size() is the period P in ticks. The body
/// advances by implicit Euler over P; its contact is its own, the same spring at the step's end to
/// the tool's sample.
struct Loop {
  Device device;
  Body body;
  Cycle cycle;
  int sample_age_ticks = 0;  // from the tool's sample to the display of the snapshot made with it,
                             // 0 to P: the cost of a prompt step; P: docs/cases.md, 1.13
};

/// One period's map of the state, from the instant at which the tool is sampled.
[[nodiscard]] Eigen::MatrixXd monodromy(const Loop& loop, double contact_N_per_m);

/// The same where not the snapshot but its force is handed over and held for the period: the force
/// at the sample, between tool and body as they then stand (docs/cases.md, 1.12 and 1.13, "force
/// held").
[[nodiscard]] Eigen::MatrixXd held_force_monodromy(const Device& device, const Body& body,
                                                   int period_ticks, double contact_N_per_m);

[[nodiscard]] double spectral_radius(const Eigen::MatrixXd& matrix);

/// Contact stiffnesses at equal ratios from lowest to highest.
struct StiffnessGrid {
  double lowest_N_per_m = 10.0;
  double highest_N_per_m = 1e5;
  int points = 241;
};

/// The first loss of stability, going up a grid.
struct StiffnessLimit {
  double last_stable_N_per_m = 0.0;  // on the grid; 0: its first is unstable
  double limit_N_per_m = 0.0;        // bisected between the two
};

/// Nothing where every stiffness of the grid is stable.
[[nodiscard]] std::optional<StiffnessLimit> stiffness_limit(
    const std::function<Eigen::MatrixXd(double contact_N_per_m)>& map,
    const StiffnessGrid& grid = {});
[[nodiscard]] std::optional<StiffnessLimit> stiffness_limit(const Loop& loop,
                                                            const StiffnessGrid& grid = {});

}  // namespace stillgrid::laboratory::two_rate

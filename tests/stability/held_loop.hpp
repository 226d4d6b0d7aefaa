#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "haptic_server/devices/phantom_model.hpp"
#include "proto/scene_segment.hpp"

namespace stillgrid::laboratory {

/// The simulated device in a loop along z: no hand, no limit of force.
struct HeldLoop {
  double mass_kg, damping_N_s_per_m, tick_s = 1e-3;
  int delay_ticks = 0;
  double friction_N = 0.0;
  double resolution_m = 0.0;  // of the encoders; 0 exact
};

[[nodiscard]] devices::PhantomModel make_device(const HeldLoop& loop);

/// The same device at the surface of a wall, moving in, and pushed in for ever.
[[nodiscard]] devices::PhantomModel make_pushed_device(const HeldLoop& loop, double push_N);

/// A wall below z = 0, touched by the tool's origin.
[[nodiscard]] proto::SceneHeader wall(double stiffness_N_per_m);

/// A spring and a damper on both sides of z = 0: two walls that face each other, each pressed
/// 50 mm deep and with half of the stiffness. Each damps where the tool approaches it, so that
/// together the contact law is -K z - B v. Pre: |z| < 50 mm.
[[nodiscard]] proto::SceneHeader spring(double stiffness_N_per_m, double damping_N_s_per_m = 0.0);

/// The force of such a scene on the tool along z.
[[nodiscard]] double force_N(const proto::SceneHeader& scene, double z_m, double velocity_m_s = 0);

/// Where the loop takes the velocity from that a virtual damper sees.
enum class VelocitySource { kBackwardDifference, kProduct };

/// Largest magnitude of an eigenvalue of the map from one tick to the next, by running the device,
/// the contact law and the velocity estimator for one tick from each unit state.
[[nodiscard]] double tick_growth(const HeldLoop& loop, double stiffness_N_per_m,
                                 double damping_N_s_per_m = 0.0,
                                 VelocitySource source = VelocitySource::kBackwardDifference);

/// The stiffness at which a spring stops being stable for the first time: scanned upwards in steps
/// of a tenth, then halved down. Pre: stable at lowest_N_per_m.
[[nodiscard]] double first_loss_N_per_m(const std::function<double(double)>& growth,
                                        double lowest_N_per_m);

/// Highest less lowest.
[[nodiscard]] double peak_to_peak(std::vector<double>::const_iterator first,
                                  std::vector<double>::const_iterator last);

}  // namespace stillgrid::laboratory

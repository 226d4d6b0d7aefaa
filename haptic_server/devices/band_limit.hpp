#pragma once

#include "haptic_server/devices/trajectory_curve.hpp"

namespace stillgrid::devices {

/// The curve without what is too fast for its knots or for the ticks that read it.
///
/// With f the lower of 0.5 / (the mean knot spacing) and 0.5 / tick_s: what moves slower than
/// 0.7 f passes, what moves faster than f does not. So neither images of a slow recording's
/// samples are left nor does a fast recording's noise fold down into the ticks. The curve is
/// continued beyond its ends by reflection in them, and keeps both ends. Orientations stay.
/// Method: a Blackman-windowed sinc [Oppenheim and Schafer, Discrete-Time Signal Processing].
/// Pre: the invariants of TrajectoryCurve; tick_s > 0.
[[nodiscard]] TrajectoryCurve band_limited(const TrajectoryCurve& curve, double tick_s);

}  // namespace stillgrid::devices

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace stillgrid::performance {

/// The estimate after one more sample, for one run; stamps grow strictly.
using VelocityUpdate =
    std::function<Eigen::Vector3d(std::uint64_t time_ns, const Eigen::Vector3d&)>;

/// An estimator of velocity with one of its settings.
struct VelocityCandidate {
  std::string name;
  double setting_ms = 0.0;  // time constant or window
  /// A fresh one for a device with encoder steps of resolution_m.
  std::function<VelocityUpdate(double resolution_m)> start;
};

/// The product's own estimator, "product", and its rivals over their settings:
///   difference         of neighbouring samples
///   window             difference over a fixed time
///   low-pass           first order, of differences
///   two low-passes     in a row, each of the setting
///   line fit           least squares over a fixed time
///   constant acceleration  an observer with three equal poles (alpha-beta-gamma, fading memory)
///   adaptive end fit, adaptive best fit  the longest window, up to the setting, to which a line
///     fits within an encoder step [Janabi-Sharifi, Hayward and Chen, IEEE Trans. Control Systems
///     Technology 8(6), 2000]
[[nodiscard]] std::vector<VelocityCandidate> velocity_candidates();

}  // namespace stillgrid::performance

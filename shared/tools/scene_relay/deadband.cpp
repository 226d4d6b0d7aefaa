#include "shared/tools/scene_relay/deadband.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stillgrid::scene_relay {
namespace {

using Vector = std::array<double, 3>;

double distance(const Vector& a, const Vector& b) {
  double squared = 0.0;  // std::hypot of three takes no notice of some NaN
  for (std::size_t i = 0; i < 3; ++i) squared += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squared);
}

/// By which one unit quaternion turns from another; by its chord, for the cosine of a small angle
/// is one.
double angle_rad(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  double apart = 0.0, opposite = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    apart += (a[i] - b[i]) * (a[i] - b[i]);
    opposite += (a[i] + b[i]) * (a[i] + b[i]);
  }
  return 4.0 * std::asin(std::min(1.0, 0.5 * std::sqrt(std::min(apart, opposite))));
}

}  // namespace

proto::ToolState led_on(const proto::ToolState& sample, std::uint64_t by_ns) noexcept {
  proto::ToolState led = sample;
  led.time_ns += by_ns;
  const double by_s = 1e-9 * static_cast<double>(std::min(by_ns, kLongestLead_ns));
  for (std::size_t i = 0; i < 3; ++i) led.position_m[i] += by_s * sample.velocity_m_s[i];
  if (by_ns > kLongestLead_ns) led.velocity_m_s = {};
  return led;
}

bool Deadband::differs(const proto::ToolState& sample) const noexcept {
  if (sample.time_ns <= sent_.time_ns) return true;
  const std::uint64_t since_ns = sample.time_ns - sent_.time_ns;
  if (since_ns >= limits_.silence_ns || sample.buttons != sent_.buttons) return true;
  const double speed_m_s = std::max(distance(sent_.velocity_m_s, {}), limits_.slow_m_s);
  // Written so that a NaN is sent.
  return !(distance(sample.velocity_m_s, sent_.velocity_m_s) <=
               limits_.velocity_share * speed_m_s &&
           distance(sample.position_m, led_on(sent_, since_ns).position_m) <= limits_.distance_m &&
           angle_rad(sample.orientation_xyzw, sent_.orientation_xyzw) <= limits_.angle_rad);
}

bool Deadband::must_send(const proto::ToolState& sample) noexcept {
  if (has_sent_ && !differs(sample)) return false;
  sent_ = sample;
  has_sent_ = true;
  return true;
}

}  // namespace stillgrid::scene_relay

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace stillgrid::laws {

/// How a hand of a formula moves: smooth, its velocity continuous.
enum class HandKind { kStill, kPress, kStroke, kTap, kPinch, kStir, kFlick };
inline constexpr std::array<std::string_view, 7> kHandNames = {"still", "press", "stroke", "tap",
                                                               "pinch", "stir",  "flick"};

/// A hand by formula, in the scene. It waits at its centre, clear of everything, for 0.15 s, by
/// which a safety chain's ramp is over, comes down by its depth as its kind has it, and stays in
/// the neighbourhood.
struct Hand {
  HandKind kind = HandKind::kPress;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // of the tool's origin
  double depth_m = 0.02;                               // below the centre
  double amplitude_m = 0.01;                           // to the sides
  double period_s = 1.0;
  double noise_m = 0.0;  // amplitude of the encoders' noise in the closed loop
};

struct HandMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
};

/// still: down within a period, then held; press: down and up once a period; stroke, and pinch
/// between two bodies: down, then to and fro along x; stir: then in circles; tap: a dip in a fifth
/// of each period; flick: across by the amplitude and back in a fifth of each period.
[[nodiscard]] HandMotion motion_at(const Hand& hand, double time_s) noexcept;

/// "press x_m=0 y_m=0 z_m=0.02 depth_m=0.03 amplitude_m=0.01 period_s=1.3".
[[nodiscard]] std::string text_of(const Hand& hand);
/// Throws std::runtime_error, one line.
[[nodiscard]] Hand hand_of(const std::string& text);

}  // namespace stillgrid::laws

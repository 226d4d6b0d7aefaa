#include "tests/laws/hand.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "tests/laws/scene_text.hpp"

namespace stillgrid::laws {
namespace {

constexpr double kWait_s = 0.15;
constexpr double kTurn = 2.0 * std::numbers::pi;

/// From 0 to 1 within `length`, at rest at both ends.
double smooth_step(double s, double length) {
  const double x = std::clamp(s / length, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

/// Where the hand is, s periods after it set out.
Eigen::Vector3d offset_m(const Hand& hand, double s) {
  const double down = smooth_step(s, 1.0) * hand.depth_m;
  const double side = smooth_step(s - 1.0, 1.0) * hand.amplitude_m;
  const double phase = s - std::floor(s);
  switch (hand.kind) {
    case HandKind::kStill:
      return {0.0, 0.0, -down};
    case HandKind::kPress:
      return {0.0, 0.0, -0.5 * hand.depth_m * (1.0 - std::cos(kTurn * s))};
    case HandKind::kTap: {
      const double dip = phase < 0.2 ? 0.5 * (1.0 - std::cos(kTurn * 5.0 * phase)) : 0.0;
      return {0.0, 0.0, -hand.depth_m * dip};
    }
    case HandKind::kStroke:
    case HandKind::kPinch:  // between two bodies
      return {side * std::sin(kTurn * s), 0.0, -down};
    case HandKind::kStir:
      return {side * std::sin(kTurn * s), side * (1.0 - std::cos(kTurn * s)), -down};
    case HandKind::kFlick: {
      const double across = phase < 0.2 ? 0.5 * (1.0 - std::cos(kTurn * 5.0 * phase)) : 0.0;
      return {hand.amplitude_m * across, 0.0, -down};
    }
  }
  return Eigen::Vector3d::Zero();
}

Eigen::Vector3d place_m(const Hand& hand, double time_s) {
  const double s = std::max(0.0, time_s - kWait_s) / hand.period_s;
  return hand.centre_m + offset_m(hand, s);
}

}  // namespace

HandMotion motion_at(const Hand& hand, double time_s) noexcept {
  constexpr double kStep_s = 1e-5;
  return {.position_m = place_m(hand, time_s),
          .velocity_m_s = (place_m(hand, time_s + kStep_s) - place_m(hand, time_s - kStep_s)) /
                          (2.0 * kStep_s)};
}

std::string text_of(const Hand& hand) {
  std::string text(kHandNames[static_cast<std::size_t>(hand.kind)]);
  const auto add = [&text](const char* key, double value) {
    text += std::string(" ") + key + "=" + short_number(value);
  };
  add("x_m", hand.centre_m.x());
  add("y_m", hand.centre_m.y());
  add("z_m", hand.centre_m.z());
  add("depth_m", hand.depth_m);
  add("amplitude_m", hand.amplitude_m);
  add("period_s", hand.period_s);
  if (hand.noise_m > 0.0) add("noise_m", hand.noise_m);
  return text;
}

Hand hand_of(const std::string& text) {
  std::istringstream words(text);
  std::string word;
  words >> word;
  const auto* const name = std::find(kHandNames.begin(), kHandNames.end(), word);
  if (name == kHandNames.end())
    throw std::runtime_error("hand '" + word +
                             "': expected still, press, stroke, tap, pinch, stir "
                             "or flick");
  Hand hand;
  hand.kind = static_cast<HandKind>(name - kHandNames.begin());
  while (words >> word) {
    const auto equals = word.find('=');
    const std::string key = word.substr(0, equals);
    double* const place = key == "x_m"           ? &hand.centre_m.x()
                          : key == "y_m"         ? &hand.centre_m.y()
                          : key == "z_m"         ? &hand.centre_m.z()
                          : key == "depth_m"     ? &hand.depth_m
                          : key == "amplitude_m" ? &hand.amplitude_m
                          : key == "period_s"    ? &hand.period_s
                          : key == "noise_m"     ? &hand.noise_m
                                                 : nullptr;
    char* end = nullptr;
    const std::string number = equals == std::string::npos ? "" : word.substr(equals + 1);
    const double value = std::strtod(number.c_str(), &end);
    if (place == nullptr || number.empty() || *end != '\0' || !std::isfinite(value))
      throw std::runtime_error("hand: '" + word +
                               "': expected x_m, y_m, z_m, depth_m, amplitude_m "
                               "or period_s, and a number");
    *place = value;
  }
  if (!(hand.period_s > 0.0)) throw std::runtime_error("hand: period_s: expected more than 0");
  return hand;
}

}  // namespace stillgrid::laws

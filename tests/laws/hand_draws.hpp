#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/laws/law_case.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {

/// What a hand comes to: a body's place and how high it is above it.
struct Target {
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  double height_m = 0.0;
  bool is_gap = false;  // between two that pinch
};

/// By formula, from above.
[[nodiscard]] Hand draw_hand(Random& random, const Target& target, double contact_distance_m,
                             bool is_pinch);
/// As haptic_server --device takes them, near what a hand by formula aims at.
[[nodiscard]] std::string draw_device(Random& random, const Hand& aim);
[[nodiscard]] std::string draw_recorded(Random& random, const Hand& aim);

/// A second hand at a body of the scene, the first one's more often than not: from above, or from
/// below, so that a body is between two.
/// Pre: the case has a hand by formula and a tool.
void draw_other_hand(LawCase& law_case, Random& random, const std::vector<Target>& targets,
                     double contact_distance_m);

}  // namespace stillgrid::laws

#include "tests/laws/hand_draws.hpp"

#include <algorithm>

namespace stillgrid::laws {

Hand draw_hand(Random& random, const Target& target, double contact_distance_m, bool is_pinch) {
  Hand hand;
  do hand.kind = static_cast<HandKind>(random.index(kHandNames.size()));
  while (hand.kind == HandKind::kPinch);
  if (is_pinch) hand.kind = HandKind::kPinch;
  const double gap_m = random.between(0.004, 0.02);
  const double into_m = random.between(0.001, 0.008);
  hand.centre_m =
      target.place_m + Eigen::Vector3d(random.between(-0.005, 0.005), random.between(-0.005, 0.005),
                                       target.height_m + contact_distance_m + gap_m);
  hand.depth_m = gap_m + (is_pinch ? contact_distance_m + target.height_m : into_m);
  hand.amplitude_m = is_pinch ? random.between(0.0005, 0.003) : random.between(0.002, 0.015);
  hand.period_s = random.over_decades(0.15, 1.2);
  return hand;
}

std::string draw_device(Random& random, const Hand& aim) {
  const std::string_view profile = random.one_of({"touch", "touchx", "premium15"});
  const std::string_view hand = random.one_of({"none", "light", "measured"});
  std::string text = "phantom:profile=" + std::string(profile) + ",hand=" + std::string(hand) +
                     ",path=" + std::string(random.one_of({"press", "stroke", "tap", "circle"}));
  const auto add = [&text](const char* key, double value) {
    text += std::string(",") + key + "=" + short_number(value);
  };
  add("centre_x_m", aim.centre_m.x());
  add("centre_y_m", aim.centre_m.y());
  add("centre_z_m", aim.centre_m.z());
  add("depth_m", aim.depth_m);
  add("amplitude_m", aim.amplitude_m);
  add("period_s", std::max(0.4, aim.period_s));
  if (hand == "none" || random.chance(0.3)) add("push_z_N", -random.between(0.2, 2.0));
  if (random.chance(0.3)) text += ",limits=0";
  return text;
}

std::string draw_recorded(Random& random, const Hand& aim) {
  const std::string_view file = random.one_of({"a_1", "a_2", "b_1", "c_1", "d_1"});
  std::string text = "replay:file=$DATA/trajectories/ku_contour_force/demo_" + std::string(file) +
                     ".csv,resample=band_limited";
  // All begin some 240 mm out along x, and press along z.
  text += ",offset_x_m=" + short_number(0.2401 + aim.centre_m.x());
  text += ",offset_y_m=" + short_number(aim.centre_m.y());
  return text + ",offset_z_m=" + short_number(aim.centre_m.z() - aim.depth_m);
}

void draw_other_hand(LawCase& law_case, Random& random, const std::vector<Target>& targets,
                     double contact_distance_m) {
  const auto tool = std::find_if(law_case.scene.sections.begin(), law_case.scene.sections.end(),
                                 [](const SceneSection& each) { return each.head == "[tool]"; });
  const std::string keys = "{ " + tool->lines.front() + " }";  // of its radius or its spheres
  law_case.scene.sections.erase(tool);
  for (const char* name : {"left", "right"}) {
    SceneSection& hand = law_case.scene.add("[[hand]]");
    hand.text("name", name);
    hand.set("tool", keys);
  }
  const Eigen::Vector3d first_m = law_case.hand->centre_m;
  const Target& target =
      random.chance(0.6)
          ? *std::min_element(targets.begin(), targets.end(),
                              [&](const Target& a, const Target& b) {
                                return (a.place_m - first_m).norm() < (b.place_m - first_m).norm();
                              })
          : targets[random.index(targets.size())];
  Hand hand = draw_hand(random, target, contact_distance_m, false);
  if (random.chance(0.5)) {
    hand.centre_m.z() = 2.0 * target.place_m.z() - hand.centre_m.z();
    hand.depth_m = -hand.depth_m;
  }
  law_case.other_hand = hand;
  // These laws' runs are shorter than a hand waits: both are there from the start.
  for (Hand* each : {&*law_case.hand, &*law_case.other_hand}) {
    each->centre_m.z() -= each->depth_m;
    each->depth_m *= 0.1;
  }
  if (law_case.law != 6) law_case.duration_s = 0.4;  // chaos grows
}

}  // namespace stillgrid::laws

#include "tests/laws/joint_draws.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace stillgrid::laws {
namespace {

struct Joinable {
  std::string name;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
};

std::vector<Joinable> joinable_of(const SceneText& scene) {
  std::vector<Joinable> found;
  for (const SceneSection& section : scene.sections) {
    const std::string mass = section.value_of("mass_kg"), kind = section.value_of("kind");
    if (section.head != "[[body]]" || mass.empty()) continue;
    if (kind != "\"rigid_box\"" && kind != "\"sphere\"") continue;
    const std::string name = section.value_of("name");
    Joinable& own = found.emplace_back();
    own.name = name.substr(1, name.size() - 2);
    own.mass_kg = std::strtod(mass.c_str(), nullptr);
    std::sscanf(section.value_of("position_m").c_str(), "[%lf, %lf, %lf]", &own.centre_m.x(),
                &own.centre_m.y(), &own.centre_m.z());
  }
  return found;
}

/// A point, and at times one beside it.
std::string draw_points(Random& random, const Eigen::Vector3d& point_m) {
  std::string text = "[";
  const std::size_t count = 1 + random.index(3);
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3d own_m = point_m;
    if (i > 0) own_m[static_cast<Eigen::Index>(i)] += 0.01;
    text += (i == 0 ? "[" : ", [") + short_number(own_m.x()) + ", " + short_number(own_m.y()) +
            ", " + short_number(own_m.z()) + "]";
  }
  return text + "]";
}

/// Its body alone on it would swing at 20 to 300 rad/s, damped by a share of critical.
void draw_spring(SceneSection& joint, Random& random, double mass_kg) {
  const double rate_rad_s = random.over_decades(20.0, 300.0);
  joint.number("stiffness_N_per_m", mass_kg * rate_rad_s * rate_rad_s);
  joint.number("damping_N_s_per_m", 2.0 * random.over_decades(0.03, 1.0) * mass_kg * rate_rad_s);
}

}  // namespace

void draw_joints(SceneText& scene, Random& random, bool may_be_hung) {
  const std::vector<Joinable> bodies = joinable_of(scene);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Joinable& body = bodies[i];
    const bool is_hung = may_be_hung && random.chance(0.3);
    if (!is_hung && (i == 0 || random.chance(0.3))) continue;
    SceneSection& joint = scene.add("[[joint]]");
    joint.text("name", "j" + std::to_string(i));
    joint.text("body", body.name);
    if (is_hung) {
      joint.set("points_m", draw_points(random, body.centre_m + Eigen::Vector3d(0.0, 0.0, 0.03)));
    } else {
      joint.text("joined_to", bodies[i - 1].name);
      joint.set("points_m", draw_points(random, 0.5 * (body.centre_m + bodies[i - 1].centre_m)));
    }
    draw_spring(joint, random, body.mass_kg);
  }
}

}  // namespace stillgrid::laws

#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "tests/laws/random.hpp"
#include "tests/laws/scene_text.hpp"

namespace stillgrid::laws {

/// What of bodies a law can speak of.
struct BodyWishes {
  bool damped = false;     // contacts and springs take energy, friction holds
  bool undamped = false;   // neither dampers nor friction
  bool still = true;       // static bodies may be drawn
  bool prescribed = true;  // moving as prescribed
  bool soft = true;        // springs
  bool pinned = true;
  bool moving = true;  // free bodies may have a velocity
  bool meshes = true;
  bool rolls = true;  // spheres
};

/// Adds a material. Returns its name.
std::string draw_material(SceneText& scene, Random& random, const BodyWishes& wishes);

/// Adds a body of any kind but a plane within 20 mm of a place. Its mass is such that contacts and
/// springs are no faster than 2,000 rad/s. Returns its height above the place.
double draw_body(SceneText& scene, Random& random, const BodyWishes& wishes,
                 const std::string& name, const std::string& material,
                 const Eigen::Vector3d& place_m);

/// Adds a level floor.
void add_floor(SceneText& scene, double height_m, const std::string& material);

}  // namespace stillgrid::laws

#pragma once

#include <Eigen/Core>
#include <string>

#include "tests/laws/hand.hpp"
#include "tests/laws/random.hpp"
#include "tests/laws/scene_text.hpp"

namespace stillgrid::laws {

/// How a box is met.
enum class BoxKind { kExact, kCompound, kSpheres, kPlane };

struct SolidTool {
  double radius_m = 0.0;
  double stiffness_N_per_m = 0.0;  // the only material's
};

/// Adds a body of the material m0, static, or free and too heavy to move.
SceneSection& add_held_body(SceneText& scene, Random& random, const std::string& name,
                            bool may_be_free = true);

/// Returns spheres of a cover, spacing at most the radius, that fit into a box of that height.
[[nodiscard]] std::string draw_packing(Random& random, double height_m);

/// Adds a box, or the plane of its upper face.
void add_solid_box(SceneText& scene, Random& random, const std::string& name, BoxKind kind,
                   const Eigen::Vector3d& middle_m, const Eigen::Vector3d& size_m,
                   bool may_be_free = true);

[[nodiscard]] BoxKind draw_box_kind(Random& random, bool may_be_plane);
/// Returns a kind with sharp edges, for faces that meet.
[[nodiscard]] BoxKind draw_sharp_kind(Random& random);

/// Adds a tool of one sphere, or of two along y, and the material m0.
SolidTool draw_solid_tool(SceneText& scene, Random& random, double friction, bool may_be_two);

/// Returns a hand from above. Its centre is so high that the tool is clear.
[[nodiscard]] Hand draw_solid_hand(Random& random, HandKind kind, const SolidTool& tool,
                                   double depth_m);

/// Returns a depth so large that spheres leave out less than a twentieth of it.
[[nodiscard]] double draw_depth_m(Random& random);

}  // namespace stillgrid::laws

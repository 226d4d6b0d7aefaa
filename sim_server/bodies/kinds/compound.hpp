#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim_server/bodies/kinds/packing.hpp"
#include "sim_server/bodies/solid_shape.hpp"
#include "sim_server/bodies/surfaces.hpp"

namespace stillgrid::toml {
class TableReader;
}

namespace stillgrid::bodies {

struct BodyDescription;

/// A rigid body of exact shapes, in its centre of mass along its principal axes, whatever frame
/// the scene has. Others meet spheres among them as collision spheres, and other shapes by their
/// distance.
struct CompoundBody {
  std::vector<SolidShape> shapes = {};
  Eigen::Vector3d inertia_per_kg_m2 = Eigen::Vector3d::Zero();  // principal
};

/// Reads `shape` into body.shape. Throws SceneError. Pre: body.motion is read.
void read_compound(toml::TableReader& table, BodyDescription& body,
                   std::vector<std::string>& notes);

/// Returns a body of these shapes and moves body's frame into its centre of mass, along its
/// principal axes. The frame keeps its axes if they are principal. Pre: shapes is not empty.
[[nodiscard]] CompoundBody compound_of(std::vector<SolidShape> shapes, BodyDescription& body);

[[nodiscard]] BodyCounts counts_of(const CompoundBody& compound);

/// Returns inertia and size of a body of that mass.
[[nodiscard]] RigidShape rigid_shape(const CompoundBody& compound, double mass_kg);
/// Spheres among the shapes, and of other shapes the contact balls that no other one hides.
[[nodiscard]] std::vector<SphereBinding> spheres_of(const CompoundBody& compound,
                                                    const BodyDescription& body);

[[nodiscard]] BodySurface surface_of(const CompoundBody& compound, const BodyDescription& body,
                                     const RestSpheres& spheres);

}  // namespace stillgrid::bodies

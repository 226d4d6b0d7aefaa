#include "shared/dynamics/description.hpp"

#include <stdexcept>
#include <string>

namespace stillgrid::dynamics {
namespace {

void require(bool is_right, const char* what, std::size_t index) {
  if (!is_right) throw std::invalid_argument(std::string(what) + " " + std::to_string(index));
}

template <class Items>
bool is_index(int index, const Items& items) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size();
}

void validate_sphere(const Description& description, std::size_t i) {
  const Description::Sphere& sphere = description.spheres[i];
  require(sphere.radius_m > 0.0, "expected a positive radius of sphere", i);
  require(is_index(sphere.material, description.materials), "unknown material of sphere", i);
  if (sphere.rigid >= 0) {
    require(is_index(sphere.rigid, description.rigid_bodies), "unknown rigid body of sphere", i);
    return;
  }
  require(sphere.node_count >= 1 && sphere.node_count <= 4, "expected 1 to 4 nodes of sphere", i);
  for (int k = 0; k < sphere.node_count; ++k)
    require(is_index(sphere.nodes[static_cast<std::size_t>(k)], description.nodes),
            "unknown node of sphere", i);
}

}  // namespace

void validate(const Description& description) {
  for (std::size_t i = 0; i < description.nodes.size(); ++i)
    require(description.nodes[i].is_pinned || description.nodes[i].mass_kg > 0.0,
            "expected a positive mass of node", i);
  for (std::size_t i = 0; i < description.springs.size(); ++i)
    require(is_index(description.springs[i].a, description.nodes) &&
                is_index(description.springs[i].b, description.nodes),
            "unknown node of spring", i);
  for (std::size_t i = 0; i < description.rigid_bodies.size(); ++i) {
    const Description::Rigid& rigid = description.rigid_bodies[i];
    require(rigid.is_driven || (rigid.mass_kg > 0.0 && rigid.inertia_kg_m2.minCoeff() > 0.0),
            "expected a positive mass and inertia of rigid body", i);
  }
  for (std::size_t i = 0; i < description.spheres.size(); ++i) validate_sphere(description, i);
  for (std::size_t i = 0; i < description.planes.size(); ++i)
    require(is_index(description.planes[i].material, description.materials),
            "unknown material of plane", i);
}

}  // namespace stillgrid::dynamics

#include "sim_server/bodies/kinds/sphere.hpp"

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

void read_sphere(toml::TableReader& table, BodyDescription& body,
                 std::vector<std::string>& /*notes*/) {
  body.position_m = table.vector_or("position_m", body.position_m);
  body.shape = SphereBody{.radius_m = table.number("radius_m", toml::Bound::kPositive)};
}

BodyCounts counts_of(const SphereBody& /*sphere*/) {
  return {.spheres = 1.0};
}

RigidShape rigid_shape(const SphereBody& sphere, double mass_kg) {
  return {Eigen::Vector3d::Constant(0.4 * mass_kg * sphere.radius_m * sphere.radius_m),
          sphere.radius_m};
}

std::vector<SphereBinding> spheres_of(const SphereBody& sphere, const BodyDescription& body) {
  std::vector<SphereBinding> spheres(1);
  spheres[0].radius_m = sphere.radius_m;
  spheres[0].rest_position_m = body.position_m;
  return spheres;
}

}  // namespace stillgrid::bodies

#include "sim_server/bodies/kinds/plane.hpp"

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

void read_plane(toml::TableReader& table, BodyDescription& body,
                std::vector<std::string>& /*notes*/) {
  body.position_m = table.vector_or("point_m", body.position_m);
  body.shape = PlaneBody{.normal = table.direction("normal")};
}

BodyCounts counts_of(const PlaneBody& /*plane*/) {
  return {};
}

}  // namespace stillgrid::bodies

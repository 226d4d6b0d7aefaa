#include "sim_server/bodies/kinds/contact_keys.hpp"

#include <Eigen/Geometry>
#include <array>
#include <string_view>

#include "sim_server/bodies/kinds/measured_surface_reader.hpp"

namespace stillgrid::bodies {
namespace {

constexpr double kFinestCell = 1e-3, kCoarsestCell = 0.1;  // of the mesh's longest side

AskedField read_field(toml::TableReader field, const Eigen::AlignedBox3d& box_m, Motion motion) {
  AskedField asked{.line = field.line(), .folder = field.folder()};
  if (field.has("cell_m")) asked.cell_m = field.number("cell_m", toml::Bound::kPositive);
  if (field.has("band_m")) asked.band_m = field.number("band_m", toml::Bound::kPositive);
  asked.measured = read_measured_surface(field, box_m, motion);
  field.finish();
  const double longest_m = box_m.sizes().maxCoeff();
  if (asked.cell_m &&
      (*asked.cell_m < kFinestCell * longest_m || *asked.cell_m > kCoarsestCell * longest_m))
    field.refuse("cell_m", "a thousandth to a tenth of the mesh's longest side");
  if (asked.band_m > longest_m) field.refuse("band_m", "at most the mesh's longest side");
  return asked;
}

}  // namespace

std::optional<AskedField> read_contact(toml::TableReader& table, const mesh::TriangleMesh& mesh,
                                       bool is_soft, Motion motion) {
  constexpr std::array<std::string_view, 2> kContacts = {"field", "spheres"};
  table.refuse_gone("normalise", "the force at rest is stiffness times depth whatever the spheres");
  table.refuse_gone("force_error", "write field = { cell_m = ... } for a finer field");
  const bool has_spheres = table.has("spheres");
  const std::size_t by_default = is_soft || has_spheres ? 1 : 0;
  if ((table.has("contact") ? table.choice("contact", kContacts) : by_default) == 1) {
    if (table.has("field")) table.refuse("field", "no such key of a mesh that is met by spheres");
    return std::nullopt;
  }
  if (is_soft) table.refuse("contact", "\"spheres\": a soft mesh deforms, which no field does");
  if (has_spheres)
    table.refuse("spheres", "no such key beside contact = \"field\", which needs none");
  return read_field(table.table("field"), box_of(mesh), motion);
}

}  // namespace stillgrid::bodies

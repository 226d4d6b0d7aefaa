#include "sim_server/bodies/kinds/contact_keys.hpp"

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "shared/rendering/force_error.hpp"
#include "sim_server/bodies/kinds/measured_surface_reader.hpp"
#include "sim_server/spheres/felt_error.hpp"

namespace stillgrid::bodies {
namespace {

constexpr std::string_view kForceError = "force_error";
constexpr double kFinestCell = 1e-3, kCoarsestCell = 0.1;  // of the mesh's longest side

/// What has no meaning beside how a mesh is met.
void refuse_beside(toml::TableReader& table, std::string_view contact,
                   std::initializer_list<std::pair<std::string_view, std::string_view>> keys) {
  for (const auto& [key, why] : keys)
    if (table.has(key))
      table.refuse(
          key, "no such key beside contact = \"" + std::string(contact) + "\"" + std::string(why));
}

/// A number up to 1000, or a text that spheres::read_force_share() takes, up to 1000 too.
double read_force_error(toml::TableReader& table) {
  constexpr double kMax = 1000.0;
  const std::optional<double> share =
      table.has_text(kForceError)
          ? spheres::read_force_share(table.name(kForceError), spheres::kAnyShare)
          : table.number(kForceError, toml::Bound::kPositive);
  if (!share || *share > kMax)
    table.refuse(kForceError,
                 "a share of the force above 0, at most 1000, such as \"5%\", 0.05 or \"0.7jnd\"");
  return *share;
}

}  // namespace

std::optional<AskedField> read_contact(toml::TableReader& table, const mesh::TriangleMesh& mesh,
                                       bool is_soft, Motion motion) {
  constexpr std::array<std::string_view, 3> kContacts = {"spheres", "field", "auto"};
  const std::size_t contact = table.has("contact") ? table.choice("contact", kContacts) : 0;
  if (contact != 2 && table.has(kForceError))
    table.refuse(kForceError, "no such key but beside contact = \"auto\"");
  if (contact == 0) {
    if (table.has("field"))
      table.refuse("field", "no such key but beside contact = \"field\" or \"auto\"");
    return std::nullopt;
  }
  if (is_soft) table.refuse("contact", "\"spheres\": a soft mesh deforms, which no field does");
  refuse_beside(table, kContacts[contact],
                {{"normalise", contact == 1 ? ", whose stiffness is the material's"
                                            : ", which normalises what it chooses"}});
  if (contact == 1) refuse_beside(table, "field", {{"spheres", ", which needs none"}});
  toml::TableReader field = table.table("field");
  AskedField asked{.is_choice = contact == 2, .line = field.line(), .folder = field.folder()};
  if (contact == 1 || field.has("cell_m"))
    asked.cell_m = field.number("cell_m", toml::Bound::kPositive);
  if (field.has("band_m")) asked.band_m = field.number("band_m", toml::Bound::kPositive);
  const Eigen::AlignedBox3d box = box_of(mesh);
  if (contact == 1) asked.measured = read_measured_surface(field, box, motion);
  field.finish();
  const double longest_m = box.sizes().maxCoeff();
  if (asked.cell_m &&
      (*asked.cell_m < kFinestCell * longest_m || *asked.cell_m > kCoarsestCell * longest_m))
    field.refuse("cell_m", "a thousandth to a tenth of the mesh's longest side");
  if (asked.band_m > longest_m) field.refuse("band_m", "at most the mesh's longest side");
  asked.max_error_share = rendering::kJustNoticeable;
  if (table.has(kForceError)) asked.max_error_share = read_force_error(table);
  return asked;
}

}  // namespace stillgrid::bodies

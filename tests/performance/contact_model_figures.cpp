// Every model of contact with a rigid mesh beside the exact mesh: prints
// docs/charts/contact_models.csv (models), which needs the folder of real inputs, with --small of
// the bunny only, or docs/charts/contact_drawn.csv (drawn), contact_corner.csv (corner).
#include <Eigen/Geometry>
#include <array>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string_view>

#include "shared/rendering/force_error.hpp"
#include "sim_server/fields/contact_choice.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/mesh/mesh_file.hpp"
#include "sim_server/mesh/mesh_repair.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "tests/performance/contact_models.hpp"
#include "tests/performance/drawn_tool.hpp"
#include "tests/sim_server/spheres/recorded_contact.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kDiagonal_m = 0.2;
constexpr std::size_t kSamples = 4000;

ModelledMesh modelled(const std::string& name, const std::filesystem::path& file) {
  ModelledMesh of{.name = name,
                  .mesh = mesh::make_closed(mesh::load_mesh(file, 1.0), name).mesh,
                  .tool_radius_m = 0.02 * kDiagonal_m,
                  .press_depth_m = 0.005 * kDiagonal_m,
                  .distance = {}};
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : of.mesh.vertices_m) box.extend(vertex_m);
  for (Eigen::Vector3d& vertex_m : of.mesh.vertices_m)
    vertex_m *= kDiagonal_m / box.diagonal().norm();
  of.distance = std::make_shared<const mesh::MeshDistance>(of.mesh);
  return of;
}

/// Each model at several finenesses, coarse to fine; made when it is asked for.
std::vector<std::function<ContactModel()>> models_of(const ModelledMesh& of, bool is_small) {
  std::vector<std::function<ContactModel()>> made;
  const auto add = [&](auto&& make, std::initializer_list<double> sizes) {
    for (const double size : sizes) {
      made.emplace_back([&of, make, size] { return make(of, size * kDiagonal_m); });
      if (is_small) return;
    }
  };
  add(decomposition_model, {0.04, 0.02, 0.01, 0.005});
  add(even_model, {0.04, 0.028, 0.02, 0.014, 0.01, 0.007});
  add(volume_model, {0.028, 0.02, 0.014, 0.01});
  add(field_model, {0.04, 0.028, 0.02, 0.014, 0.01, 0.007, 0.005, 0.0035});
  made.emplace_back([&of] { return exact_model(of); });
  return made;
}

double mean_touched(const ContactModel& model, const spheres::ExactForces& places) {
  double sum = 0.0;
  for (const Eigen::Vector3d& tool_m : places.tool_m)
    sum += model.touched ? model.touched(tool_m) : 0.0;
  return sum / static_cast<double>(places.tool_m.size());
}

/// What contact = "auto" takes for a static body, if its force may err by so much.
ContactModel chosen_model(const ModelledMesh& of, double error_jnd) {
  const fields::ContactNeed need{
      .tool_radius_m = of.tool_radius_m,
      .press_depth_m = of.press_depth_m,
      .max_error_share = error_jnd * rendering::kJustNoticeable,
      .make_field = [&](double cell_m) {
        return std::make_shared<const collision::DistanceField>(fields::make_mesh_field(
            of.mesh, {cell_m, of.tool_radius_m, of.tool_radius_m + 4.0 * cell_m}));
      }};
  const fields::ContactChoice choice = fields::choose_contact(of.mesh, need);
  ContactModel model =
      choice.field ? field_model(of, choice.cell_m) : sphere_model("", of, choice.balls, 0.0);
  model.name = choice.field ? "chosen: field" : "chosen: spheres";
  return model;
}

void compare_models(bool is_small) {
  const auto data = spheres::real_data();
  if (!data) throw std::runtime_error("expected $STILLGRID_DATA or ../shared/data");
  std::printf(
      "mesh,model,size_mm,parts,bytes,touched,hot_ns,flushed_ns,"
      "error_jnd,best_jnd,depths_jnd\n");
  for (const auto& [name, file] : {std::pair("bunny", "npm_bunny.off"),
                                   {"spot", "mujoco_spot.obj"},
                                   {"liver", "sofa_liver-smooth.obj"}}) {
    const ModelledMesh of = modelled(name, *data / "meshes" / file);
    const double depth_m = of.press_depth_m;
    const auto press = [&](std::span<const double> depths_m) {
      return spheres::press_everywhere(of.mesh, *of.distance, kSamples, of.tool_radius_m, depths_m);
    };
    const spheres::ExactForces one = press(std::array{depth_m}),
                               several = press(std::array{0.5 * depth_m, depth_m, 2.0 * depth_m});
    std::vector<std::function<ContactModel()>> models = models_of(of, is_small);
    for (const double error_jnd : {2.0, 1.0})
      models.emplace_back([&of, error_jnd] { return chosen_model(of, error_jnd); });
    for (const auto& make : models) {
      const ContactModel model = make();
      const QueryTime time = time_query(model, one.tool_m, is_small);
      std::printf("%s,%s,%.4g,%zu,%.0f,%.2f,%.1f,%.0f,%.4f,%.4f,%.4f\n", name, model.name.c_str(),
                  1e3 * model.size_m, model.parts, model.bytes, mean_touched(model, one),
                  time.hot_ns, time.flushed_ns, spheres::unscaled_error(one, model.force).jnd(),
                  spheres::felt_error(one, model.force).jnd(),
                  spheres::felt_error(several, model.force).jnd());
      std::fflush(stdout);
    }
    if (is_small) return;
  }
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  using namespace std::string_view_literals;
  const std::string_view table = argc > 1 ? argv[1] : "";
  const bool is_small = argc > 2 && argv[2] == "--small"sv;
  try {
    if (table == "models")
      stillgrid::performance::compare_models(is_small);
    else if (table == "drawn")
      stillgrid::performance::print_drawn_tool();
    else if (table == "corner")
      stillgrid::performance::print_rod_in_corner();
    else
      throw std::runtime_error("expected models, drawn or corner");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "contact_model_figures: %s\n", error.what());
    return 1;
  }
}

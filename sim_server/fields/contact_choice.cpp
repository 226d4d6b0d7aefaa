#include "sim_server/fields/contact_choice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/fields/field_force.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/felt_error.hpp"

namespace stillgrid::fields {
namespace {

constexpr std::size_t kSamples = 2000;
constexpr std::array kDepths = {0.5, 1.0, 2.0};  // of the press

// Parts of the mesh's longest side, each about 0.7 of the one before, and of its diagonal.
constexpr std::array kCells = {12.0, 17.0, 24.0, 34.0, 48.0, 68.0, 96.0, 136.0, 192.0};
constexpr std::array kTolerances = {20.0, 40.0, 80.0, 160.0};

// Weights in evaluations of a spring (dynamics/choice/counted_work.hpp): of a tick in contact, and
// of a sphere in a step of a body that moves.
constexpr double kFieldTick = 590.0, kLeastTick = 260.0, kTouchedTick = 100.0;
constexpr double kDoubledTick = 107.0;  // for each doubling of the spheres
constexpr double kSphereStep = 28.0;

/// One candidate with its model.
struct Made {
  choice::Record record;
  double cell_m = 0.0;
  std::shared_ptr<const collision::DistanceField> field = nullptr;
  std::vector<spheres::Ball> balls = {};
  double stiffness_scale = 1.0;
};

std::string name_of(const char* kind, double size_m) {
  std::array<char, 60> text{};
  std::snprintf(text.data(), text.size(), "%s %.3g mm", kind, 1e3 * size_m);
  return text.data();
}

std::vector<Made> fields_of(double side_m, const ContactNeed& need,
                            const spheres::ExactForces& places) {
  std::vector<double> cells_m;
  for (const double part : kCells) cells_m.push_back(side_m / part);
  if (need.cell_m) cells_m = {*need.cell_m};
  std::vector<Made> all;
  for (const double cell_m : cells_m) {
    Made made{.record = {.name = name_of("field, cells of", cell_m)}, .cell_m = cell_m};
    try {
      made.field = need.make_field(cell_m);
    } catch (const std::invalid_argument&) {
      if (need.cell_m) throw;
      break;  // finer ones take more
    }
    const collision::FieldView view = made.field->view();
    made.record.spheres = made.field->shape().fine_count;
    made.record.bytes = static_cast<double>(made.field->bytes());
    made.record.work_per_ms =
        kFieldTick + need.steps_per_ms * kSphereStep * static_cast<double>(need.points);
    made.record.error_share = spheres::unscaled_error(places, [&](const Eigen::Vector3d& tool_m) {
                                return unit_force_m(view, tool_m, need.tool_radius_m);
                              }).share;
    all.push_back(std::move(made));
    if (*all.back().record.error_share <= need.max_error_share) break;
  }
  return all;
}

Made spheres_of(std::string name, std::vector<spheres::Ball> balls, const ContactNeed& need,
                const spheres::ExactForces& places) {
  const spheres::BallBody body = spheres::make_ball_body(balls, need.tool_radius_m);
  double touched = 0.0;
  for (const Eigen::Vector3d& tool_m : places.tool_m)
    for (const std::uint32_t ball : spheres::balls_near(body.grid, tool_m))
      touched += (balls[ball].centre_m - tool_m).norm() < balls[ball].radius_m + need.tool_radius_m;
  const auto count = static_cast<double>(balls.size());
  const spheres::FeltError error = spheres::felt_error(
      places, [&](const Eigen::Vector3d& tool_m) { return spheres::unit_force_m(body, tool_m); });
  Made made{.record = {.name = std::move(name)}};
  made.record.spheres = balls.size();
  made.record.bytes =
      8.0 * static_cast<double>(collision::grid_layout(0, balls.size()).total_words);
  made.record.work_per_ms =
      std::max(kLeastTick, kDoubledTick * (std::log2(count) - 1.5) +
                               kTouchedTick * touched / static_cast<double>(places.tool_m.size())) +
      need.steps_per_ms * kSphereStep * count;
  made.record.error_share = error.share;
  made.balls = std::move(balls);
  made.stiffness_scale = error.stiffness_scale;
  return made;
}

}  // namespace

ContactChoice choose_contact(const mesh::TriangleMesh& closed, const ContactNeed& need) {
  std::array<double, kDepths.size()> depths_m{};
  std::ranges::transform(kDepths, depths_m.begin(),
                         [&](double depth) { return depth * need.press_depth_m; });
  const spheres::ExactForces places = spheres::press_everywhere(
      closed, mesh::MeshDistance(closed), kSamples, need.tool_radius_m, depths_m);
  if (places.tool_m.empty())
    throw std::invalid_argument("no place that the tool's sphere can reach");
  Eigen::AlignedBox3d box_m;
  for (const Eigen::Vector3d& vertex_m : closed.vertices_m) box_m.extend(vertex_m);
  std::vector<Made> all = fields_of(box_m.sizes().maxCoeff(), need, places);
  if (!need.given_balls.empty()) {
    all.push_back(spheres_of("spheres as given", need.given_balls, need, places));
  } else {
    for (const double part : kTolerances) {
      const double size_m = box_m.diagonal().norm() / part;
      all.push_back(spheres_of(name_of("spheres within", size_m),
                               spheres::decompose(closed, size_m).balls, need, places));
    }
  }
  // Spheres that do not push at all are no model, however much may err.
  std::erase_if(all, [](const Made& made) { return !(made.stiffness_scale > 0.0); });
  if (all.empty()) throw std::invalid_argument("neither a field nor spheres can be made of it");
  ContactChoice choice;
  for (const Made& made : all) choice.records.push_back(made.record);
  Made& best = all[choice::choose_record(choice.records, need.max_error_share)];
  choice.chosen = best.record;
  choice.keeps_error = choice::keeps_error(best.record, need.max_error_share);
  choice.field = best.field;
  choice.cell_m = best.cell_m;
  choice.balls = std::move(best.balls);
  choice.stiffness_scale = best.stiffness_scale;
  return choice;
}

}  // namespace stillgrid::fields

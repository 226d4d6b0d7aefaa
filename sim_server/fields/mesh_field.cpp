#include "sim_server/fields/mesh_field.hpp"

#include <algorithm>

#include "sim_server/fields/stiffness_map.hpp"
#include "sim_server/mesh/mass_properties.hpp"
#include "sim_server/mesh/mesh_distance.hpp"

namespace stillgrid::fields {
namespace {

/// About the bytes of a field: bricks fill the box, and those with a part within reach of the
/// surface have fine coefficients too (shared/collision/field_making.cpp).
double estimated_bytes(const Eigen::AlignedBox3d& box_m, double area_m2, double cell_m,
                       double band_m, double margin_m) {
  constexpr double kBeyond = 7.8;  // cells from the band to the middles of fine bricks
  constexpr double kCoarseBytes = 12.0, kFineBytes = 4.0 * proto::kBrickCoefficients;
  const double brick_m = proto::kBrickCells * cell_m;
  const double filled_m3 = (box_m.sizes().array() + 2.0 * (margin_m + brick_m)).prod();
  const double near_m3 = 2.0 * area_m2 * (std::max(band_m, cell_m) + kBeyond * cell_m);
  return (kCoarseBytes * filled_m3 + kFineBytes * std::min(near_m3, filled_m3)) /
         (brick_m * brick_m * brick_m);
}

}  // namespace

double default_cell_m(const mesh::TriangleMesh& closed, double tool_radius_m, double band_m,
                      double margin_m) {
  constexpr double kCoarsest = 1.0 / 32.0, kFinest = 1e-3;  // of the longest side
  constexpr double kWider = 1.1;
  const Eigen::AlignedBox3d box_m = mesh::box_of(closed);
  const double longest_m = box_m.sizes().maxCoeff(), area_m2 = mesh::surface_area_m2(closed);
  const double half_thickness_m = mesh::mass_properties(closed).volume_m3 / area_m2;
  double cell_m = std::min({0.5 * tool_radius_m, half_thickness_m, kCoarsest * longest_m});
  cell_m = std::max(cell_m, kFinest * longest_m);
  while (estimated_bytes(box_m, area_m2, cell_m, band_m, margin_m) > kDefaultFieldBytes)
    cell_m *= kWider;
  return cell_m;
}

collision::DistanceField make_mesh_field(const mesh::TriangleMesh& closed,
                                         const collision::FieldFineness& fineness,
                                         const MeasuredSurface& measured) {
  const Eigen::AlignedBox3d box = mesh::box_of(closed);
  const Eigen::Vector3d grown_m = Eigen::Vector3d::Constant(std::max(measured.offset_m, 0.0));
  const Eigen::AlignedBox3d solid_m(box.min() - grown_m, box.max() + grown_m);
  const mesh::MeshDistance distance(closed);
  collision::ScalarField stiffness_scale;
  if (!measured.places.empty())
    stiffness_scale = [map = StiffnessMap(measured.places, measured.own_N_per_m),
                       own_N_per_m = measured.own_N_per_m,
                       &distance](const Eigen::Vector3d& point_m) {
      return map.stiffness_N_per_m(distance.closest(point_m).point_m) / own_N_per_m;
    };
  const auto distance_m = [&](const Eigen::Vector3d& point_m) {
    return distance.signed_distance_m(point_m) - measured.offset_m;
  };
  return collision::make_field(solid_m, fineness, distance_m, stiffness_scale);
}

}  // namespace stillgrid::fields

#include "tests/performance/contact_models.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>

#include "shared/collision/grid_query.hpp"
#include "shared/collision/sphere_history.hpp"
#include "shared/publication/scene_segment.hpp"
#include "sim_server/fields/field_force.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/spheres/decomposition.hpp"
#include "sim_server/spheres/effective_stiffness.hpp"
#include "sim_server/spheres/felt_error.hpp"
#include "sim_server/spheres/sampling.hpp"
#include "tests/laboratory/rivals/penetration_volume.hpp"
#include "tests/performance/sphere_cloud.hpp"

namespace stillgrid::performance {
namespace {

constexpr std::size_t kSamples = 2000;  // as a scene is normalised with

}  // namespace

SphereGrid::SphereGrid(const std::vector<spheres::Ball>& balls) : grid_(0, balls.size()) {
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Eigen::Vector3f p = balls[i].centre_m.cast<float>();
    proto::SphereRecord& record = grid_.records()[i];
    collision::fill_history(record, proto::SphereState{{p.x(), p.y(), p.z()}, {}});
    record.radius_m = static_cast<float>(balls[i].radius_m);
  }
  grid_.enter(collision::history_bounds(grid_.records()), publication::StaticScene{}.voxel_ratio);
  view_ = grid_.view();
}

Eigen::Vector3d SphereGrid::force_m(const Eigen::Vector3d& tool_m, double radius_m) const {
  const Eigen::Vector3f p = tool_m.cast<float>();
  const auto radius = static_cast<float>(radius_m);
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  collision::for_each_candidate(
      view_, {{p.x(), p.y(), p.z()}, radius}, 8192, [&](std::uint32_t sphere) {
        const proto::SphereRecord line = collision::load_record(view_, sphere);
        const Eigen::Vector3d apart_m =
            tool_m -
            Eigen::Map<const Eigen::Vector3f>(line.newest.position_m.data()).cast<double>();
        const double distance_m = apart_m.norm();
        const double depth_m = radius_m + double{line.radius_m} - distance_m;
        if (depth_m > 0.0 && distance_m > 0.0) sum_m += depth_m / distance_m * apart_m;
      });
  return sum_m;
}

ContactModel sphere_model(const std::string& name, const ModelledMesh& of,
                          const std::vector<spheres::Ball>& balls, double size_m) {
  const auto grid = std::make_shared<const SphereGrid>(balls);
  const double scale = spheres::stiffness_scale(balls, spheres::sample_surface(of.mesh, kSamples),
                                                of.tool_radius_m, of.press_depth_m);
  const double radius_m = of.tool_radius_m;
  return {name,
          size_m,
          balls.size(),
          static_cast<double>(grid->bytes()),
          [grid, scale, radius_m](const Eigen::Vector3d& tool_m) -> Eigen::Vector3d {
            return scale * grid->force_m(tool_m, radius_m);
          },
          [balls, radius_m](const Eigen::Vector3d& tool_m) {
            return static_cast<double>(
                std::count_if(balls.begin(), balls.end(), [&](const spheres::Ball& ball) {
                  return (ball.centre_m - tool_m).norm() < ball.radius_m + radius_m;
                }));
          }};
}

ContactModel decomposition_model(const ModelledMesh& of, double tolerance_m) {
  return sphere_model("spheres", of, spheres::decompose(of.mesh, tolerance_m).balls, tolerance_m);
}

ContactModel even_model(const ModelledMesh& of, double spacing_m) {
  return sphere_model("even spheres", of, spheres::surface_balls(of.mesh, spacing_m, spacing_m),
                      spacing_m);
}

ContactModel volume_model(const ModelledMesh& of, double spacing_m) {
  const auto volume = std::make_shared<const laboratory::VolumeBody>(laboratory::make_volume_body(
      spheres::surface_balls(of.mesh, spacing_m, spacing_m),
      spheres::sample_surface(of.mesh, kSamples), of.tool_radius_m, of.press_depth_m));
  const spheres::BallBody& balls = volume->balls;
  const double bytes =
      static_cast<double>(balls.balls.size() * sizeof(spheres::Ball) +
                          4 * (balls.grid.starts.size() + balls.grid.entries.size()));
  return {"penetration volume", spacing_m, balls.balls.size(), bytes,
          [volume](const Eigen::Vector3d& tool_m) {
            return laboratory::unit_volume_force_m(*volume, tool_m);
          }};
}

ContactModel field_model(const ModelledMesh& of, double cell_m) {
  const auto field = std::make_shared<const collision::DistanceField>(fields::make_mesh_field(
      of.mesh, {cell_m, of.tool_radius_m, of.tool_radius_m + 4.0 * cell_m}));
  const double radius_m = of.tool_radius_m;
  return {"field", cell_m, field->shape().fine_count, static_cast<double>(field->bytes()),
          [field, radius_m](const Eigen::Vector3d& tool_m) {
            return fields::unit_force_m(field->view(), tool_m, radius_m);
          }};
}

ContactModel exact_model(const ModelledMesh& of) {
  const auto distance = of.distance;
  const double radius_m = of.tool_radius_m;
  return {"nearest point", 0.0, of.mesh.triangles.size(),
          static_cast<double>(24 * of.mesh.vertices_m.size() + 12 * of.mesh.triangles.size()),
          [distance, radius_m](const Eigen::Vector3d& tool_m) {
            return spheres::exact_force_m(*distance, tool_m, radius_m);
          }};
}

QueryTime time_query(const ContactModel& model, const std::vector<Eigen::Vector3d>& places_m,
                     bool is_small) {
  const auto median = [](std::vector<double>& times) {
    std::nth_element(times.begin(), times.begin() + std::ssize(times) / 2, times.end());
    return 1e9 * times[times.size() / 2];
  };
  constexpr std::size_t kStride = 7919;  // prime: from place to place, none near the last
  std::size_t at = 0;
  const auto next = [&] { return at = (at + kStride) % places_m.size(); };
  std::vector<double> hot_s, flushed_s, clock_s;
  const int rounds = is_small ? 5 : 41, each = 200;
  for (int round = 0; round < rounds; ++round) {
    // The same few places: nearby ones, as a hand that moves slowly asks.
    const Eigen::Vector3d place_m = places_m[next()];
    hot_s.push_back(seconds_of([&] {
                      for (int i = 0; i < each; ++i)
                        benchmark::DoNotOptimize(
                            model.force(place_m + Eigen::Vector3d(1e-6 * i, 0.0, -1e-6 * i)));
                    }) /
                    each);
  }
  CacheFlush flush;
  for (int round = 0; round < (is_small ? 5 : 61); ++round) {
    const Eigen::Vector3d place_m = places_m[next()];
    flush();
    clock_s.push_back(seconds_of([] {}));
    flushed_s.push_back(seconds_of([&] { benchmark::DoNotOptimize(model.force(place_m)); }));
  }
  return {median(hot_s), median(flushed_s) - median(clock_s)};
}

}  // namespace stillgrid::performance

// Fig. 5 of the paper, redrawn: prints docs/charts/row_ripple.csv.
#include <cmath>
#include <cstdio>
#include <vector>

#include "sim_server/spheres/force_map.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kContactDistance_m = 0.015;  // radius of a ball and of the tool, together
constexpr double kTool_m = 0.005;
constexpr double kDepth_m = 0.002;
constexpr double kStiffness_N_per_m = 500.0;
constexpr double kPi = 3.14159265358979323846;

std::vector<spheres::Ball> lattice(double spacing_m, int rows) {
  constexpr int kEachWay = 20;
  const int each_across = rows > 1 ? kEachWay : 0;
  std::vector<spheres::Ball> balls;
  for (int y = -each_across; y <= each_across; ++y)
    for (int x = -kEachWay; x <= kEachWay; ++x)
      balls.push_back({{x * spacing_m, y * spacing_m, 0.0}, kContactDistance_m - kTool_m});
  return balls;
}

/// Even places over one period of the tops.
spheres::SurfaceSamples one_period(double spacing_m, int along, int across) {
  spheres::SurfaceSamples samples;
  for (int y = 0; y < across; ++y)
    for (int x = 0; x < along; ++x) {
      samples.points_m.emplace_back((x + 0.5) / along * spacing_m,
                                    across > 1 ? (y + 0.5) / across * spacing_m : 0.0,
                                    kContactDistance_m - kTool_m);
      samples.normals.emplace_back(0.0, 0.0, 1.0);
    }
  return samples;
}

spheres::ForceMap map_of(const std::vector<spheres::Ball>& balls,
                         const spheres::SurfaceSamples& samples, double depth_m) {
  const spheres::BallBody body = spheres::make_ball_body(balls, kTool_m);
  return spheres::map_force(samples, kTool_m, depth_m, [&](const Eigen::Vector3d& tool_m) {
    return spheres::unit_force_m(body, tool_m);
  });
}

void print_row(const char* panel, double spacing_m, double x, double measured, double formula) {
  std::printf("%s,%.6g,%.6g,%.8g,%.8g\n", panel, 1e3 * spacing_m, x, measured, formula);
}

void print_line(double spacing_m) {
  const spheres::BallBody body = spheres::make_ball_body(lattice(spacing_m, 1), kTool_m);
  for (int i = -200; i <= 200; ++i) {
    const double x_m = i * 1e-4;
    const Eigen::Vector3d force_N =
        kStiffness_N_per_m * spheres::unit_force_m(body, {x_m, 0.0, kContactDistance_m - kDepth_m});
    print_row("force_N_along_mm", spacing_m, 1e3 * x_m, force_N.z(), NAN);
  }
}

void print_ripple(double spacing_m) {
  const double h_m = kContactDistance_m - kDepth_m,
               c_m = std::sqrt(kContactDistance_m * kContactDistance_m - h_m * h_m);
  const double mean_N = kStiffness_N_per_m * h_m / spacing_m *
                        (2.0 * kContactDistance_m * std::asinh(c_m / h_m) - 2.0 * c_m);
  const spheres::ForceMap map =
      map_of(lattice(spacing_m, 1), one_period(spacing_m, 4000, 1), kDepth_m);
  print_row("mean_N", spacing_m, 1e3 * spacing_m, kStiffness_N_per_m * map.mean_m, mean_N);
  print_row("ripple", spacing_m, 1e3 * spacing_m, map.ripple, NAN);
  print_row("least_over_most", spacing_m, 1e3 * spacing_m, map.min_over_max, NAN);
  print_row("holes", spacing_m, 1e3 * spacing_m, map.hole_share, NAN);
}

void print_sheet(double spacing_m, double depth_m) {
  const double stiffness_N_per_m = kPi * kStiffness_N_per_m *
                                   (2.0 * kContactDistance_m * depth_m - 3.0 * depth_m * depth_m) /
                                   (spacing_m * spacing_m);
  const spheres::ForceMap map =
      map_of(lattice(spacing_m, 2), one_period(spacing_m, 300, 300), depth_m);
  print_row("sheet_N_per_m_by_mm", spacing_m, 1e3 * depth_m,
            kStiffness_N_per_m * map.effective_stiffness, stiffness_N_per_m);
}

int program_main() {
  std::printf("quantity,spacing_mm,x,measured,formula\n");
  for (const double spacing_m : {0.005, 0.010, 0.0125, 0.018}) print_line(spacing_m);
  for (int i = 12; i <= 80; ++i) print_ripple(0.00025 * i);
  for (const double spacing_m : {0.005, 0.0075, 0.010})
    for (int i = 1; i <= 44; ++i) print_sheet(spacing_m, i * 0.00025);
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  return stillgrid::performance::program_main();
}

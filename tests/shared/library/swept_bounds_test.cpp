#include <algorithm>
#include <random>

#include "shared/publication/moving_records.hpp"
#include "tests/shared/library/published_ball.hpp"

namespace stillgrid::library::swept_bounds_test {
namespace {

using Eigen::Vector3d;

/// Whether each sphere's published bound holds it in both snapshots of its history.
void check_bounds(publication::MovingRecords& moving) {
  const auto numbers = moving.grid().sorted_numbers();
  const auto bounds = moving.grid().sorted_bounds();
  REQUIRE(moving.grid().view().shape.sphere_count == moving.count());
  std::vector<bool> is_entered(moving.count());
  for (std::size_t k = 0; k < moving.count(); ++k) {
    const proto::SphereRecord& record = moving.records()[numbers[k]];
    is_entered[numbers[k]] = true;
    const auto vector = [](const std::array<float, 3>& v) { return Vector3d(v[0], v[1], v[2]); };
    for (const Vector3d& place_m :
         {vector(record.newest.position_m), vector(record.before.position_m)}) {
      if (place_m.hasNaN()) continue;
      const double margin_m =
          (place_m - vector(bounds[k].centre_m)).norm() + double{record.radius_m};
      REQUIRE(margin_m <= double{bounds[k].bounding_radius_m} * (1.0 + 1e-7));
    }
  }
  REQUIRE(std::all_of(is_entered.begin(), is_entered.end(), [](bool is) { return is; }));
}

TEST_CASE("Swept bounds hold every sphere however it moves, comes and goes", "[moving_records]") {
  std::mt19937 random(GENERATE(range(1U, 17U)));
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const double period_s = 0.001 * std::pow(40.0, 0.5 + 0.5 * share(random));
  const double speed_m_s = std::pow(10.0, 2.0 * share(random) - 1.0);
  constexpr std::size_t kMaxSpheres = 60;
  publication::MovingRecords moving(kMaxSpheres);
  std::vector<double> radii_m(kMaxSpheres), places_m(3 * kMaxSpheres),
      velocities_m_s(3 * kMaxSpheres);
  for (double& radius_m : radii_m) radius_m = 0.005 * std::pow(3.0, share(random));
  for (double& x : places_m) x = 0.1 * share(random);
  for (double& v : velocities_m_s) v = speed_m_s * share(random);
  stillgrid_shapes shapes{};
  shapes.struct_size = sizeof shapes;
  shapes.count = 40;
  shapes.radii_m = radii_m.data();
  moving.declare(shapes);
  for (int step = 0; step < 200; ++step) {
    for (std::size_t i = 0; i < places_m.size(); ++i) {
      if (share(random) > 0.95) velocities_m_s[i] = speed_m_s * share(random);
      places_m[i] += period_s * velocities_m_s[i];
    }
    if (step % 37 == 36) places_m[0] += 5.0 * share(random);  // leaps
    if (step % 23 == 22) {
      shapes.count = 1 + static_cast<std::uint32_t>(59.9 * std::abs(share(random)));
      moving.declare(shapes);
    }
    moving.place(places_m.data(), step % 5 == 4 ? nullptr : velocities_m_s.data(), period_s);
    check_bounds(moving);
  }
}

}  // namespace
}  // namespace stillgrid::library::swept_bounds_test

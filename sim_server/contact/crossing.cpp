#include "sim_server/contact/crossing.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::contact {
namespace {

constexpr double kDeepest = 0.5;  // of the smaller radius, by which one step may deepen a contact
constexpr double kGraze = 0.01;   // of the smaller radius: no meeting
// Of the smaller radius: no path as short as this crosses more than a graze, whose chord is at
// least 2 sqrt(2 (2 r) 0.01 r).
constexpr double kShortestPath = 0.4;

}  // namespace

double share_before_crossing(const RelativePath& path, double radius_a_m,
                             double radius_b_m) noexcept {
  const Eigen::Vector3d move_m = path.to_m - path.from_m;
  const double smaller_m = std::min(radius_a_m, radius_b_m),
               contact_distance_m = radius_a_m + radius_b_m;
  const double length_m = move_m.norm();
  if (length_m <= kShortestPath * smaller_m) return 1.0;
  const double nearest_share = -path.from_m.dot(move_m) / (length_m * length_m);
  // Written so that NaN is no crossing.
  if (!(nearest_share > 0.0 && nearest_share < 1.0)) return 1.0;

  const double nearest_m = (path.from_m + nearest_share * move_m).norm();
  if (nearest_m > contact_distance_m - kGraze * smaller_m) return 1.0;
  const double start_m = std::min(path.from_m.norm(), contact_distance_m);
  const bool is_seen =
      path.from_m.norm() < contact_distance_m || path.to_m.norm() < contact_distance_m;
  if (is_seen && start_m - nearest_m <= kDeepest * smaller_m) return 1.0;
  const double stop_m = std::max(nearest_m, start_m - kDeepest * smaller_m);
  const double before_m = std::sqrt(std::max(0.0, stop_m * stop_m - nearest_m * nearest_m));
  return nearest_share - before_m / length_m;
}

double share_before_crossings(std::span<const Contact> contacts,
                              std::span<const bodies::SphereMotion> start,
                              std::span<const bodies::SphereMotion> end) noexcept {
  double share = 1.0;
  for (const Contact& contact : contacts) {
    if (contact.is_plane) continue;
    const auto a = static_cast<std::size_t>(contact.a);
    RelativePath path{start[a].position_m - contact.start_b_m,
                      end[a].position_m - contact.position_b_m};
    if (contact.b >= 0) {
      const auto b = static_cast<std::size_t>(contact.b);
      path = {start[a].position_m - start[b].position_m, end[a].position_m - end[b].position_m};
    }
    share = std::min(share, share_before_crossing(path, contact.radius_a_m, contact.radius_b_m));
  }
  return share;
}

}  // namespace stillgrid::contact

// How fast spheres move in a tick, and how finely it is divided because of that.
#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/sphere_ways.hpp"

namespace stillgrid::dynamics {
namespace {

// A contact acts along the normal at the middle of a substep. This share of the smaller radius
// bounds the turn of the normal within half a substep to 1/16 rad, and the error of the depth to
// an eighth of the radius.
constexpr double kLongestWay = 0.25;
constexpr int kMaxSubsteps = 64;

}  // namespace

/// Sets how far each sphere moves in a tick. Returns whether one moves farther than half of what
/// divides a tick. Pre: the margins of other spheres are those of the tick.
bool Engine::measure_ways(double tick_s) {
  const double longest = 0.5 * kLongestWay * smallest_length_m_;
  bool is_fast = false;
  for (std::size_t i = 0; i < balls_.rigid.size(); ++i) {
    const double square = state_.rigid_velocity_m_s[at(balls_.rigid[i])].vector().squaredNorm();
    is_fast = is_fast || tick_s * tick_s * square > longest * longest;
  }
  for (const OtherSphere& sphere : other_spheres_)
    is_fast = is_fast || static_cast<double>(bodies_.places[at(sphere.place)].margin_m) > longest;
  if (!is_fast) return false;
  for (std::size_t i = 0; i < balls_.rigid.size(); ++i)
    ways_m_[at(balls_.place[i])] =
        static_cast<float>(tick_s * state_.rigid_velocity_m_s[at(balls_.rigid[i])].vector().norm());
  for (const OtherSphere& sphere : other_spheres_)
    ways_m_[at(sphere.place)] = bodies_.places[at(sphere.place)].margin_m;
  return true;
}

/// Substeps that two spheres, or a sphere and a plane, need for their relative speed: one if they
/// pass by each other.
int Engine::substeps_of_pair(const RowPlace& place, std::size_t lane, bool is_plane,
                             double tick_s) const {
  const auto sphere_at = [&](std::int32_t number) -> const Description::Sphere& {
    return description_.spheres[at(listing_.order()[at(number)])];
  };
  const Description::Sphere& a = sphere_at(place.sphere_a[lane]);
  const Eigen::Vector3d from_m = sphere_position_m(a, state_).vector();
  const Eigen::Vector3d velocity_m_s = sphere_velocity_m_s(a, state_);
  const auto length_m = [&](std::int32_t number) {
    return listing_.lengths_m()[at(listing_.order()[at(number)])];
  };
  double least_length_m = length_m(place.sphere_a[lane]), path_m = 0.0;
  if (is_plane) {
    const Description::Plane& plane = description_.planes[at(place.sphere_b[lane])];
    path_m = std::abs(tick_s * plane.normal.dot(velocity_m_s));
    if (plane.normal.dot(from_m) - plane.offset_m - a.radius_m > path_m) return 1;
  } else {
    const Description::Sphere& b = sphere_at(place.sphere_b[lane]);
    const Eigen::Vector3d relative_m = tick_s * (velocity_m_s - sphere_velocity_m_s(b, state_));
    const double least_m =
        least_distance_m(from_m - sphere_position_m(b, state_).vector(), relative_m);
    if (least_m > a.radius_m + b.radius_m) return 1;
    least_length_m = std::min(least_length_m, length_m(place.sphere_b[lane]));
    path_m = relative_m.norm();
  }
  return substeps_of_path(path_m / least_length_m);
}

/// A way in lengths of the smaller of two things that meet.
int Engine::substeps_of_path(double lengths) {
  return static_cast<int>(std::clamp<double>(std::ceil(lengths / kLongestWay), 1.0, kMaxSubsteps));
}

/// So many that no two spheres that meet in the tick move by more than a share of the smaller
/// radius relative to each other.
int Engine::substeps_by_speed(double tick_s) {
  int most = substeps_of_path(fields_.most_lengths(listing_, state_, tick_s, kLongestWay));
  if (!measure_ways(tick_s)) return most;
  const double longest = kLongestWay * smallest_length_m_;
  for (const RowGroup& group : listing_.rows().groups) {
    const bool is_plane = group.b == SideKind::kPlane;
    for (std::size_t row = group.first; row < group.end; ++row) {
      const RowPlace& place = listing_.rows().places[row];
      for (std::size_t lane = 0; lane < kRowLanes; ++lane) {
        if (place.stiffness_N_per_m[lane] == 0.0F) continue;  // an unused lane
        if (!is_plane && listing_.is_field(place.sphere_b[lane])) continue;
        const float path_m = ways_m_[at(place.sphere_a[lane])] +
                             (is_plane ? 0.0F : ways_m_[at(place.sphere_b[lane])]);
        if (static_cast<double>(path_m) > longest)
          most = std::max(most, substeps_of_pair(place, lane, is_plane, tick_s));
      }
    }
  }
  return most;
}

}  // namespace stillgrid::dynamics

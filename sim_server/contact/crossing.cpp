#include "sim_server/contact/crossing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim_server/contact/field_crossing.hpp"

namespace stillgrid::contact {
namespace {

constexpr double kDeepest = 0.5;  // of the smaller radius, by which one step may deepen a contact
constexpr double kGraze = 0.01;   // of the smaller radius: no meeting
// Of the smaller radius: no straight path as short as this crosses more than a graze, whose chord
// is at least 2 sqrt(2 (2 r) 0.01 r).
constexpr double kShortestPath = 0.4;
constexpr std::size_t kMaxChords = 64;
constexpr double kOffChord = 0.02;  // of the smaller radius, that a way leaves its chords by

/// From corner k to the next: where the line through them is nearest to the origin.
struct Chord {
  Eigen::Vector3d from_m, move_m;
  double length_m, foot;  // foot: in chords from `from`, unbounded

  Chord(std::span<const Eigen::Vector3d> corners_m, std::size_t k)
      : from_m(corners_m[k]), move_m(corners_m[k + 1] - corners_m[k]), length_m(move_m.norm()) {
    foot = length_m > 0.0 ? -from_m.dot(move_m) / (length_m * length_m) : 0.0;
  }
  [[nodiscard]] double distance_m(double share) const { return (from_m + share * move_m).norm(); }
  [[nodiscard]] double nearest_share() const { return std::clamp(foot, 0.0, 1.0); }
};

/// The body of a sphere whose way is not straight; null: it is.
const bodies::RigidBody* swinging_body(const Ways& ways, int sphere) {
  if (ways.world == nullptr || sphere < 0) return nullptr;
  const int rigid = bodies::rigid_of(*ways.world, sphere);
  if (rigid < 0) return nullptr;
  const bodies::RigidBody& body = ways.world->rigid_bodies[static_cast<std::size_t>(rigid)];
  return !body.free && bodies::swings(body) ? &body : nullptr;
}

/// Chords that a way is to be taken for.
std::size_t chords_of(const bodies::RigidBody* body, double duration_s, double radius_m) {
  if (body == nullptr) return 1;
  const double rate_rad_s = 2.0 * std::numbers::pi * body->prescribed.frequency_hz;
  const double most_m_s2 = std::abs(body->prescribed.amplitude_m) * rate_rad_s * rate_rad_s;
  const double aside_m = most_m_s2 * duration_s * duration_s / 8.0;
  const double chords = std::ceil(std::sqrt(aside_m / (kOffChord * radius_m)));
  return static_cast<std::size_t>(std::clamp(chords, 1.0, static_cast<double>(kMaxChords)));
}

Eigen::Vector3d place_m(const Ways& ways, int sphere, const bodies::RigidBody* body, double share) {
  const auto i = static_cast<std::size_t>(sphere);
  const Eigen::Vector3d& from_m = ways.start[i].position_m;
  if (share == 0.0) return from_m;
  if (share == 1.0) return ways.end[i].position_m;
  if (body == nullptr) return from_m + share * (ways.end[i].position_m - from_m);
  const double time_s = ways.world->time_s;
  return from_m + (bodies::prescribed_state(*body, time_s + share * ways.duration_s).position_m -
                   bodies::prescribed_state(*body, time_s).position_m);
}

using Corners = std::array<Eigen::Vector3d, kMaxChords + 1>;

/// The way of a contact's first sphere seen from its second. Pre: no plane.
std::span<const Eigen::Vector3d> relative_way(const Contact& contact, const Ways& ways,
                                              Corners& corners_m) {
  const bodies::RigidBody *a = swinging_body(ways, contact.a), *b = swinging_body(ways, contact.b);
  const double smaller_m = std::min(contact.radius_a_m, contact.radius_b_m);
  const std::size_t chords =
      std::max(chords_of(a, ways.duration_s, smaller_m), chords_of(b, ways.duration_s, smaller_m));
  for (std::size_t k = 0; k <= chords; ++k) {
    const double share = k == chords ? 1.0 : static_cast<double>(k) / static_cast<double>(chords);
    corners_m[k] = place_m(ways, contact.a, a, share) -
                   (contact.b >= 0 ? place_m(ways, contact.b, b, share)
                                   : kinematic_position_m(contact, share));
  }
  return {corners_m.data(), chords + 1};
}

}  // namespace

double share_before_crossing(const RelativePath& path, double radius_a_m,
                             double radius_b_m) noexcept {
  return share_before_crossing(std::array{path.from_m, path.to_m}, radius_a_m, radius_b_m);
}

double share_before_crossing(std::span<const Eigen::Vector3d> corners_m, double radius_a_m,
                             double radius_b_m) noexcept {
  const double smaller_m = std::min(radius_a_m, radius_b_m),
               contact_distance_m = radius_a_m + radius_b_m;
  const std::size_t chords = corners_m.size() - 1;
  const auto share_of = [&](std::size_t k, double share) {
    return (static_cast<double>(k) + share) / static_cast<double>(chords);
  };
  double length_m = 0.0, nearest_m = std::numeric_limits<double>::infinity(), nearest_share = 0.0;
  for (std::size_t k = 0; k < chords; ++k) {
    const Chord chord(corners_m, k);
    length_m += chord.length_m;
    const double share = chord.nearest_share(), distance_m = chord.distance_m(share);
    if (!(distance_m < nearest_m)) continue;
    nearest_m = distance_m;
    nearest_share = share_of(k, share);
  }
  // Written so that NaN is no crossing.
  if (chords == 1 && !(length_m > kShortestPath * smaller_m)) return 1.0;
  if (!(nearest_share > 0.0 && nearest_share < 1.0)) return 1.0;
  if (!(nearest_m <= contact_distance_m - kGraze * smaller_m)) return 1.0;

  const double from_m = corners_m.front().norm(), start_m = std::min(from_m, contact_distance_m);
  const bool is_seen = from_m < contact_distance_m || corners_m.back().norm() < contact_distance_m;
  if (is_seen && start_m - nearest_m <= kDeepest * smaller_m) return 1.0;
  const double stop_m = std::max(nearest_m, start_m - kDeepest * smaller_m);
  for (std::size_t k = 0; k < chords; ++k) {
    const Chord chord(corners_m, k);
    if (!(chord.distance_m(chord.nearest_share()) <= stop_m)) continue;
    const double foot_m = chord.distance_m(chord.foot);
    const double before_m = std::sqrt(std::max(0.0, stop_m * stop_m - foot_m * foot_m));
    return share_of(k, std::clamp(chord.foot - before_m / chord.length_m, 0.0, 1.0));
  }
  return nearest_share;
}

double share_before_crossings(std::span<const Contact> contacts, const Ways& ways) noexcept {
  double share = 1.0;
  Corners corners_m;
  for (const Contact& contact : contacts) {
    if (contact.is_plane) continue;
    if (is_of_field(ways, contact)) {
      share = std::min(share, share_before_field(contact, ways));
      continue;
    }
    share = std::min(share, share_before_crossing(relative_way(contact, ways, corners_m),
                                                  contact.radius_a_m, contact.radius_b_m));
  }
  return share;
}

bool meet(const Contact& contact, const Ways& ways) noexcept {
  const double contact_distance_m = contact.radius_a_m + contact.radius_b_m;
  if (is_of_field(ways, contact)) return meets_field(contact, ways);
  if (contact.is_plane)
    return contact_depth_m(contact, ways.end[static_cast<std::size_t>(contact.a)].position_m) > 0.0;
  Corners corners_m;
  const std::span<const Eigen::Vector3d> way_m = relative_way(contact, ways, corners_m);
  for (std::size_t k = 0; k + 1 < way_m.size(); ++k) {
    const Chord chord(way_m, k);
    if (chord.distance_m(chord.nearest_share()) < contact_distance_m) return true;
  }
  return false;
}

}  // namespace stillgrid::contact

#include "shared/rendering/touched_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shared/collision/grid_query.hpp"
#include "shared/display/displayed.hpp"
#include "shared/rendering/tool_sweep.hpp"

namespace stillgrid::rendering {
namespace {

/// Where the weights alone display a sphere of the grid.
display::DisplayedSphere displayed(const collision::GridView& grid, std::uint32_t sphere,
                                   const collision::RecordLine& line,
                                   const display::SnapshotWeights& weights) {
  return display::displayed(line, weights, [&] { return collision::load_record(grid, sphere); });
}

/// Displays a sphere that some snapshot lacks by those it is in.
void show_where_present(const collision::GridView& grid, std::uint32_t sphere,
                        const display::SnapshotWeights& weights, TouchedSphere& touch) {
  const display::DisplayedSphere shown =
      display::displayed_where_present(collision::load_record(grid, sphere), weights);
  touch.position_m = touch.seen_m = shown.position_m;
  touch.velocity_m_s = shown.velocity_m_s;
  touch.presence = shown.presence;
}

/// No mode moves faster, whatever a segment says: no hand does.
constexpr double kFastest_m_s = 2.0;
/// A sphere as it is displayed, and the response by which it is; without one where it cannot be
/// near.
struct Shown {
  TouchedSphere touch;
  Eigen::Vector3d displaced_m;
  std::optional<display::ResponseMatrix> response;
};

Shown shown_sphere(const collision::GridView& grid, std::uint32_t number,
                   const collision::RecordLine& line, const DisplayedMotion& motion,
                   const PlacedToolSphere& probe, double room_m) {
  const CompliantDisplay& compliant = motion.compliant_display;
  const display::DisplayedSphere now = displayed(grid, number, line, motion.now);
  Shown shown{{.position_m = now.position_m,
               .velocity_m_s = now.velocity_m_s,
               .radius_m = static_cast<double>(line.radius_m),
               .material = line.material,
               .tool_sphere = 0,
               .swept = false,
               .number = number,
               .body = line.body,
               .led_m_s = now.velocity_m_s},
              Eigen::Vector3d::Zero(),
              std::nullopt};
  shown.touch.base_m = shown.touch.seen_m = now.position_m;
  const double near_m = probe.radius_m + shown.touch.radius_m + room_m;
  if (!((now.position_m - probe.position_m).squaredNorm() < near_m * near_m)) return shown;
  if (motion.now.prediction_s > 0.0)
    shown.touch.led_m_s =
        Eigen::Map<const Eigen::Vector3f>(line.predicted_velocity_m_s.data()).cast<double>();
  TouchedSphere& touch = shown.touch;
  touch.position_m += compliant.share * compliant.shifts.of(line.body);
  touch.base_m = touch.seen_m = touch.position_m;
  touch.base_m_s = touch.velocity_m_s;
  shown.response = display::response_of(grid, line, compliant.motion.largest_response);
  if (shown.response) give_way(compliant.motion, *shown.response, touch);
  shown.displaced_m = touch.position_m - now.position_m;
  return shown;
}

/// Where the sphere meets the probe; false where it does not.
bool meets(const collision::GridView& grid, const collision::RecordLine& line,
           const DisplayedMotion& motion, const PlacedToolSphere& probe, Shown& shown) {
  TouchedSphere& touch = shown.touch;
  const double contact_distance_m = probe.radius_m + touch.radius_m;
  // Written so that a NaN does not pass.
  const auto is_within = [&](double distance_m) {
    return (touch.position_m - probe.position_m).squaredNorm() < distance_m * distance_m;
  };
  if (is_within(contact_distance_m + (shown.response ? motion.compliant_display.slack_m : 0.0)))
    return true;
  if (touch.position_m.hasNaN()) {
    show_where_present(grid, touch.number, motion.now, touch);
    shown.response.reset();
    return is_within(contact_distance_m);
  }
  const display::DisplayedSphere before = displayed(grid, touch.number, line, motion.before);
  const auto closest_m =
      closest_line_m(probe.before_m - before.position_m - shown.displaced_m,
                     probe.position_m - touch.position_m, contact_distance_m, probe.radius_m);
  if (!closest_m) return false;
  touch.position_m = touch.seen_m = probe.position_m - *closest_m;
  touch.swept = true;
  return true;
}

void add(TouchedSpheres& touched, const Shown& shown, std::uint32_t tool_sphere) {
  if (!shown.touch.velocity_m_s.allFinite() || !std::isfinite(shown.touch.radius_m)) return;
  if (touched.count == TouchedSpheres::kCapacity) {
    touched.truncated = true;
    return;
  }
  TouchedSphere& touch = touched.spheres[touched.count++];
  touch = shown.touch;
  touch.tool_sphere = tool_sphere;
  if (!shown.response || touched.response_count == TouchedSpheres::kResponseCapacity) return;
  touched.responses[touched.response_count++] = *shown.response;
  touch.response = static_cast<std::uint32_t>(touched.response_count);
}

}  // namespace

Eigen::Vector3d displayed_m(const collision::GridView& grid, std::uint32_t number,
                            const display::SnapshotWeights& weights,
                            const CompliantDisplay& compliant_display) noexcept {
  const collision::RecordLine line = collision::load_line(grid, number);
  const Eigen::Vector3d base_m = displayed(grid, number, line, weights).position_m +
                                 compliant_display.share * compliant_display.shifts.of(line.body);
  const display::ModeMotion& motion = compliant_display.motion;
  const auto response = display::response_of(grid, line, motion.largest_response);
  return response ? Eigen::Vector3d(base_m + motion.displacement_m(*response, line.body, base_m))
                  : base_m;
}

void give_way(const display::ModeMotion& motion, const display::ResponseMatrix& response,
              TouchedSphere& sphere, const Eigen::Vector3d& to_body_m) noexcept {
  place(motion, response.cast<double>() * motion.displacements,
        response.cast<double>() * motion.drift_per_s, sphere, to_body_m);
}

void place(const display::ModeMotion& motion, const Eigen::Vector3d& straight_m,
           const Eigen::Vector3d& beside_m_s, TouchedSphere& sphere,
           const Eigen::Vector3d& to_body_m) noexcept {
  const Eigen::Vector3d way_m =
      straight_m + motion.curved_m(sphere.body, sphere.base_m + to_body_m);
  sphere.position_m = sphere.base_m + way_m;
  sphere.seen_m = sphere.base_m + motion.turn_share * way_m;
  const Eigen::Vector3d modes_m_s = motion.rate_per_s * straight_m + beside_m_s;
  const double speed_m_s = modes_m_s.norm();
  sphere.velocity_m_s = sphere.base_m_s;
  // Written so that what is no number adds nothing.
  if (speed_m_s > 0.0 && speed_m_s <= proto::kLargestNumber)
    sphere.velocity_m_s += std::min(1.0, kFastest_m_s / speed_m_s) * modes_m_s;
}

void TouchedSpheres::drop_swept() noexcept {
  const auto last =
      std::remove_if(spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const TouchedSphere& sphere) { return sphere.swept; });
  count = static_cast<std::size_t>(last - spheres.begin());
}

void gather_touched(const collision::GridView& grid, const DisplayedMotion& shown,
                    std::span<const PlacedToolSphere> tool, TouchedSpheres& touched) noexcept {
  const CompliantDisplay& compliant = shown.compliant_display;
  const double room_m = compliant.share * compliant.shifts.longest_m() + compliant.slack_m +
                        compliant.motion.longest_m();
  for (std::uint32_t i = 0; i < tool.size(); ++i) {
    const PlacedToolSphere& probe = tool[i];
    const bool truncated = collision::for_each_candidate(
        grid, bound_tool_sweep(probe, room_m), kMaxVisits, [&](std::uint32_t number) {
          if (!touched.may_visit()) return;
          const collision::RecordLine line = collision::load_line(grid, number);
          if (line.material == proto::kFieldPoint) return;
          Shown sphere = shown_sphere(grid, number, line, shown, probe, room_m);
          if (meets(grid, line, shown, probe, sphere)) add(touched, sphere, i);
        });
    touched.truncated = touched.truncated || truncated;
  }
}

}  // namespace stillgrid::rendering

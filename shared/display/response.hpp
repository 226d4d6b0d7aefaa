#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "proto/scene_segment.hpp"
#include "shared/collision/grid_query.hpp"

namespace stillgrid::display {

/// How far each mode of a snapshot's response is displayed beside what velocities show; sqrt(J).
using ModeDisplacements = Eigen::Matrix<double, static_cast<int>(proto::kMaxModes), 1>;
/// A sphere's part in each mode; sqrt(m/N).
using ResponseMatrix = Eigen::Matrix<float, 3, static_cast<int>(proto::kMaxModes)>;

/// What a mode does of the hand's push now: offset + compliance (push - that of the snapshot).
struct ModeLaw {
  double offset = 0.0;      // sqrt(J)
  double compliance = 0.0;  // of the mode's own, which is 1 in a whole step
  double push = 0.0;        // sqrt(J), of the snapshot
};

/// Whether what a mode tells of itself may be true. Realtime: yes.
[[nodiscard]] inline bool is_sound(const proto::ResponseMode& mode) noexcept {
  const auto is_small = [](double x) { return std::abs(x) <= proto::kLargestNumber; };
  // Written so that a NaN does not pass.
  return mode.inertia_share >= 0.0F && mode.inertia_share <= 1.0F && is_small(mode.push) &&
         is_small(mode.displacement) && is_small(mode.at_velocity);
}

/// A mode's law when that share of the predicted step is over. It gives way as an implicit step so
/// long, of its inertia and its stiffness; beyond the step it is led by such a step too, from the
/// velocity that the snapshot has, less what the predicted velocity shows of it. Of a mode that
/// lies none. Realtime: yes.
[[nodiscard]] inline ModeLaw mode_law(const proto::ResponseMode& mode, double step_share) noexcept {
  const double inertia = mode.inertia_share, push = mode.push, whole = mode.displacement,
               at_velocity = mode.at_velocity;
  if (!is_sound(mode) || !(step_share > 0.0)) return {};
  const double resists = inertia + (1.0 - inertia) * step_share * step_share;
  const double compliance = step_share * step_share / resists;
  const double led =
      compliance * (whole - inertia * at_velocity) + step_share * inertia / resists * at_velocity;
  // Within the step its chord bears more (docs/algorithms/predict.md); they meet at its end.
  return {step_share > 1.0 ? led - step_share * whole : 0.0, compliance, push};
}

/// Whether a mode gives way in the small steps of an explicit scene, not in one. Realtime: yes.
[[nodiscard]] inline bool gives_way_by_steps(const proto::ResponseMode& mode) noexcept {
  return mode.damping_share >= 0.0F;
}

/// Where a mode that gives way by steps is in one of them.
struct ModeState {
  double way = 0.0;    // since the snapshot, sqrt(J)
  double speed = 0.0;  // sqrt(J) in a whole step
};

/// A mode's law at the end of a step within the predicted one: implicit Euler's, of its inertia,
/// its damping and its stiffness. from, to: shares of the predicted step. Of a mode that lies none.
/// Realtime: yes.
[[nodiscard]] inline ModeLaw step_law(const proto::ResponseMode& mode, const ModeState& before,
                                      double from, double to) noexcept {
  const double inertia = mode.inertia_share, damping = mode.damping_share, step = to - from;
  // Written so that a NaN does not pass.
  if (!is_sound(mode) || !(damping >= 0.0 && damping <= 1.0) || !(step > 0.0)) return {};
  const double stiffness = std::max(0.0, 1.0 - inertia - damping);
  const double resists = inertia + step * (damping + step * stiffness);
  const double force = mode.displacement - inertia * mode.at_velocity;
  const double way = (inertia * (before.way + step * before.speed) + step * damping * before.way +
                      step * step * force) /
                     resists;
  return {way - to * mode.displacement, step * step / resists, mode.push};
}

/// The state at the end of that step, when the mode is displaced by so much beside what velocities
/// show. Realtime: yes. Pre: from < to.
[[nodiscard]] inline ModeState state_after(const proto::ResponseMode& mode, const ModeState& before,
                                           double from, double to, double displaced) noexcept {
  const double way = displaced + to * mode.displacement;
  return {way, (way - before.way) / (to - from)};
}

/// The response of a sphere of a moving grid; none where it has none, or its record lies.
/// Realtime: yes. Pre: finite largest_response.
[[nodiscard]] inline std::optional<ResponseMatrix> response_of(const collision::GridView& grid,
                                                               const collision::RecordLine& line,
                                                               double largest_response) noexcept {
  if (line.response == 0 || line.response > grid.response_count) return std::nullopt;
  const proto::SphereResponse response = collision::load_response(grid, line.response - 1);
  const auto matrix = Eigen::Map<const ResponseMatrix>(response.modes.front().data());
  // Written so that a NaN does not pass.
  if (!(static_cast<double>(matrix.squaredNorm()) <= largest_response * largest_response))
    return std::nullopt;
  return matrix;
}

/// How a snapshot's modes move its spheres.
struct ModeMotion {
  ModeDisplacements displacements = ModeDisplacements::Zero();
  double rate_per_s = 0.0;  // of velocities by displacements: 1 / time since the snapshot, or
                            // since the tick before
  ModeDisplacements drift_per_s = ModeDisplacements::Zero();  // of velocities without them
  double led_s = 0.0;             // for which what turns is led on at its predicted velocity
  double largest_response = 0.0;  // sqrt(m/N), of any sphere; zero: nothing gives way
  double turn_share = 1.0;        // of a displacement, by which it turns the normal of a contact
  std::array<proto::TurningBody, proto::kMaxTurningBodies> turning{};
  std::size_t turning_count = 0;

  /// No sphere is displaced by more.
  [[nodiscard]] double longest_m() const noexcept {
    return (1.0 + kMaxCurved) * largest_response * displacements.norm();
  }

  /// By how much a sphere is displaced, where it is base_m without: by its response, and as a part
  /// of a body that turns on the arc instead of its tangent. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d displacement_m(const ResponseMatrix& response, std::uint32_t body,
                                               const Eigen::Vector3d& base_m) const noexcept {
    return response.cast<double>() * displacements + curved_m(body, base_m);
  }

  /// What of it the arc adds to the tangent. Realtime: yes.
  [[nodiscard]] Eigen::Vector3d curved_m(std::uint32_t body,
                                         const Eigen::Vector3d& base_m) const noexcept {
    for (std::size_t i = 0; i < turning_count; ++i)
      if (turning[i].body == body) return curved_m(turning[i], base_m);
    return Eigen::Vector3d::Zero();
  }

 private:
  static constexpr double kMaxCurved = 0.5;  // of the longest straight way

  [[nodiscard]] Eigen::Vector3d curved_m(const proto::TurningBody& body,
                                         const Eigen::Vector3d& base_m) const noexcept {
    const auto vector = [](const std::array<float, 3>& v) {
      return Eigen::Map<const Eigen::Vector3f>(v.data()).cast<double>();
    };
    const Eigen::Vector3d turn_rad =
        Eigen::Map<const ResponseMatrix>(body.turns.front().data()).cast<double>() * displacements;
    const double angle_rad = turn_rad.norm();
    // Written so that a NaN does not pass.
    if (!(angle_rad > 1e-9 && angle_rad < 1e3)) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d arm_m =
        base_m - vector(body.centre_m) - led_s * vector(body.velocity_m_s);
    const Eigen::Vector3d axis = turn_rad / angle_rad, tangent_m = axis.cross(arm_m);
    const Eigen::Vector3d way_m = (std::sin(angle_rad) - angle_rad) * tangent_m +
                                  (1.0 - std::cos(angle_rad)) * axis.cross(tangent_m);
    const double most_m = kMaxCurved * largest_response * displacements.norm();
    const double way = way_m.norm();
    if (!(way <= most_m))
      return way > most_m ? Eigen::Vector3d(most_m / way * way_m)
                          : Eigen::Vector3d(Eigen::Vector3d::Zero());
    return way_m;
  }
};

}  // namespace stillgrid::display

#include "shared/rendering/mode_response.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace stillgrid::rendering {
namespace {

constexpr int kMaxIterations = 8, kMaxSwitchIterations = 24;
/// Far below what a hand feels, or a motor resolves.
constexpr double kTolerance_N = 1e-5;
/// A sphere that gives way sideways is pushed on sideways, as the normal turns. Where that
/// outweighs what resists it, no step of such a length has one answer: normals turn by less.
constexpr double kMaxSoftening = 0.5;
/// No push moves a sphere farther, whatever a segment says.
constexpr double kFarthest_m = 1.0;

constexpr int kModes = static_cast<int>(proto::kMaxModes);
using display::ModeDisplacements;
using Matrix = Eigen::Matrix<double, kModes, kModes>;

/// What the tool does to a sphere, and how that falls as the sphere gives way.
struct Push {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Matrix3d resistance_N_per_m = Eigen::Matrix3d::Zero();
};

/// False where they do not touch, or a tick shows what the tick before gathered for another tool.
bool push_on(const proto::SceneHeader& scene, const TouchedSphere& sphere,
             std::span<const PlacedToolSphere> tool, const ToolPose& pose, double rate_per_s,
             Push& push) {
  if (sphere.response == 0 || sphere.material >= scene.material_count ||
      sphere.tool_sphere >= tool.size())
    return false;
  const ToolContact contact = contact_with(sphere, tool[sphere.tool_sphere]);
  if (!(contact.depth_m > 0.0)) return false;
  const collision::ContactMaterial material = contact_material(scene, sphere.material);
  ToolForce force;
  add_contact(force, material, contact, pose, sphere.presence);
  push.force_N = -force.force_N;
  push.resistance_N_per_m = force.stiffness_N_per_m;
  const Eigen::Vector3d relative_m_s = relative_velocity_m_s(contact, pose);
  const double separation_m_s = contact.normal.dot(relative_m_s);
  const double slip_m_s = (relative_m_s - separation_m_s * contact.normal).norm();
  const double drag_N_s_per_m = material.friction *
                                std::max(0.0, contact.normal.dot(force.force_N)) /
                                std::max(slip_m_s, material.slip_speed_m_s);
  const double damping_N_s_per_m = separation_m_s < 0.0 ? material.damping_N_s_per_m : 0.0;
  const Eigen::Matrix3d along = contact.normal * contact.normal.transpose();
  push.resistance_N_per_m += rate_per_s * (sphere.presence * damping_N_s_per_m * along +
                                           drag_N_s_per_m * (Eigen::Matrix3d::Identity() - along));
  return true;
}

/// One evaluation: the push on the modes, and what resists their displacements.
struct Evaluation {
  ModeDisplacements push = ModeDisplacements::Zero();
  Matrix resistance = Matrix::Zero();
  double softening = 0.0;          // of the scene's own resistance, by normals that turn
  double stiffness_N_per_m = 0.0;  // of the stiffest contact that there may be
};

Evaluation evaluate(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                    std::span<const PlacedToolSphere> tool, const ToolPose& pose, double rate_per_s,
                    const ModeDisplacements& root) {
  Evaluation sum;
  for (const TouchedSphere& sphere : touched.all()) {
    Push push;
    if (sphere.response != 0 && sphere.material < scene.material_count)
      sum.stiffness_N_per_m = std::max(sum.stiffness_N_per_m,
                                       double{scene.materials[sphere.material].stiffness_N_per_m});
    if (!push_on(scene, sphere, tool, pose, rate_per_s, push)) continue;
    const Eigen::Matrix<double, 3, kModes> own = touched.response_of(sphere).cast<double>();
    sum.push.noalias() += own.transpose() * push.force_N;
    sum.softening += push.force_N.norm() * (own * root.asDiagonal()).squaredNorm() /
                     (tool[sphere.tool_sphere].radius_m + sphere.radius_m);
    sum.resistance.noalias() += own.transpose() * (push.resistance_N_per_m * own);
  }
  return sum;
}

}  // namespace

void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) noexcept {
  for (std::size_t i = 0; i < touched.count; ++i) {
    TouchedSphere& sphere = touched.spheres[i];
    if (sphere.response != 0) give_way(motion, touched.response_of(sphere), sphere);
  }
}

void ModeResponse::take(const proto::SnapshotHeader& snapshot,
                        const display::SnapshotWeights& weights) noexcept {
  const double period_s = 1e-9 * static_cast<double>(snapshot.prediction_ns);
  motion.rate_per_s = weights.step_share > 0.0 ? 1.0 / (weights.step_share * period_s) : 0.0;
  motion.led_s = weights.prediction_s - weights.compliance_lag_s;
  motion.largest_response = snapshot.largest_response;
  motion.turning = snapshot.turning;
  motion.turning_count = std::min<std::size_t>(snapshot.turning_count, proto::kMaxTurningBodies);
  count = std::min<std::size_t>(snapshot.mode_count, proto::kMaxModes);
  // Written so that a NaN does not pass.
  if (!(motion.largest_response > 0.0 && motion.largest_response <= proto::kLargestNumber)) {
    motion.largest_response = 0.0;
    count = 0;
  }
  if (count > 0 && display::gives_way_by_steps(snapshot.modes.front()))
    return take_step(snapshot, weights.step_share, period_s);
  motion.drift_per_s.setZero();
  for (std::size_t i = 0; i < proto::kMaxModes; ++i) {
    const display::ModeLaw before = laws[i];
    laws[i] =
        i < count ? display::mode_law(snapshot.modes[i], weights.step_share) : display::ModeLaw{};
    auto& displacement = motion.displacements[static_cast<Eigen::Index>(i)];
    displacement = laws[i].compliance > 0.0 ? displacement + laws[i].offset - before.offset : 0.0;
  }
}

/// From where the last tick left the modes; a new snapshot from its own state in one. One that
/// stands takes none.
void ModeResponse::take_step(const proto::SnapshotHeader& snapshot, double step_share,
                             double period_s) noexcept {
  const bool is_new = snapshot.snapshot_id != snapshot_id;
  if (!is_new && !(step_share > to)) return;
  for (std::size_t i = 0; i < proto::kMaxModes; ++i) {
    const proto::ResponseMode& mode = snapshot.modes[i];
    auto& displaced = motion.displacements[static_cast<Eigen::Index>(i)];
    starts[i] = is_new ? display::ModeState{0.0, mode.at_velocity}
                       : display::state_after(mode, starts[i], from, to, displaced);
    laws[i] = i < count ? display::step_law(mode, starts[i], is_new ? 0.0 : to, step_share)
                        : display::ModeLaw{};
    if (!(laws[i].compliance > 0.0)) displaced = 0.0;
  }
  from = is_new ? 0.0 : to;
  to = step_share;
  snapshot_id = snapshot.snapshot_id;
  // A step's velocity is its way over its length, and a sphere's is the snapshot's but for that.
  motion.rate_per_s = to > from ? 1.0 / ((to - from) * period_s) : 0.0;
  for (std::size_t i = 0; i < proto::kMaxModes; ++i)
    motion.drift_per_s[static_cast<Eigen::Index>(i)] =
        laws[i].compliance > 0.0
            ? motion.rate_per_s * (to * snapshot.modes[i].displacement - starts[i].way) -
                  snapshot.modes[i].at_velocity / period_s
            : 0.0;
}

void ModeResponse::follow(const ModeDisplacements& push) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    const auto mode = static_cast<Eigen::Index>(i);
    motion.displacements[mode] = laws[i].offset + laws[i].compliance * (push[mode] - laws[i].push);
  }
  const double far_m = motion.largest_response * motion.displacements.norm();
  if (!(far_m <= kFarthest_m))
    motion.displacements *= far_m > kFarthest_m ? kFarthest_m / far_m : 0.0;
}

double solve_response(const proto::SceneHeader& scene, std::span<const PlacedToolSphere> tool,
                      const ToolPose& pose, double radius_m, bool is_switch,
                      TouchedSpheres& touched, ModeResponse& response) noexcept {
  const auto count = static_cast<Eigen::Index>(response.count);
  if (count == 0) return 0.0;
  ModeDisplacements root = ModeDisplacements::Zero(), offset = root, own_push = root;
  for (Eigen::Index i = 0; i < count; ++i) {
    const display::ModeLaw& law = response.laws[static_cast<std::size_t>(i)];
    root[i] = std::sqrt(law.compliance);
    offset[i] = law.offset;
    own_push[i] = law.push;
  }
  // Displacements are offset + root * unknown: the matrix is symmetric in these.
  ModeDisplacements start = response.motion.displacements;
  const double farthest_m = kMaxCompliantShift * radius_m;
  double change_N = 0.0;
  const int most = is_switch ? kMaxSwitchIterations : kMaxIterations;
  for (int iteration = 0; iteration < most; ++iteration) {
    if (is_switch) start = response.motion.displacements;
    const Evaluation now = evaluate(scene, touched, tool, pose, response.motion.rate_per_s, root);
    response.motion.turn_share =
        now.softening > kMaxSoftening ? kMaxSoftening / now.softening : 1.0;
    ModeDisplacements residual = ModeDisplacements::Zero();
    for (Eigen::Index i = 0; i < count; ++i)
      if (root[i] > 0.0)
        residual[i] = root[i] * (now.push[i] - own_push[i]) -
                      (response.motion.displacements[i] - offset[i]) / root[i];
    const Matrix matrix =
        Matrix::Identity() + root.asDiagonal() * now.resistance * root.asDiagonal();
    const ModeDisplacements by = root.cwiseProduct(matrix.ldlt().solve(residual));
    if (!by.allFinite()) break;
    const ModeDisplacements before = response.motion.displacements;
    ModeDisplacements way = before + by - start;
    const double way_m = response.motion.largest_response * way.norm();
    if (way_m > farthest_m) way *= farthest_m / way_m;
    response.motion.displacements = start + way;
    change_N = now.stiffness_N_per_m * response.motion.largest_response *
               (response.motion.displacements - before).norm();
    give_way(response.motion, touched);
    if (!(change_N > kTolerance_N)) return 0.0;
  }
  return change_N;
}

}  // namespace stillgrid::rendering

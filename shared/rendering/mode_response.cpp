#include "shared/rendering/mode_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stillgrid::rendering {
namespace {

constexpr int kMaxIterations = 12, kMaxSwitchIterations = 24;
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

/// A sphere's part in each mode; sqrt(m/N).
using Part = Eigen::Matrix<double, kModes, 3>;

/// What the tool does to a sphere, and how that falls as the sphere gives way.
struct Push {
  Eigen::Vector3d force_N, normal;
  Eigen::Vector3d by_depth;              // of the force, by what presses: friction goes with it
  double along_N_per_m, across_N_per_m;  // the normal
  std::size_t response;
};

/// False where they do not touch, or a tick shows what the tick before gathered for another tool.
bool push_on(const proto::SceneHeader& scene, const TouchedSphere& sphere,
             std::span<const PlacedToolSphere> tool, const ToolPose& pose, double rate_per_s,
             Push& push) {
  if (sphere.tool_sphere >= tool.size()) return false;
  const ToolContact contact = contact_with(sphere, tool[sphere.tool_sphere]);
  if (!(contact.depth_m > 0.0)) return false;
  const collision::ContactMaterial material = contact_material(scene, sphere.material);
  const Eigen::Vector3d relative_m_s = relative_velocity_m_s(contact, pose);
  push.normal = contact.normal;
  push.force_N = -sphere.presence * collision::contact_force_N(material, contact.depth_m,
                                                               contact.normal, relative_m_s);
  const double separation_m_s = contact.normal.dot(relative_m_s);
  const double slip_m_s = (relative_m_s - separation_m_s * contact.normal).norm();
  const double damping_N_s_per_m = separation_m_s < 0.0 ? material.damping_N_s_per_m : 0.0;
  push.along_N_per_m =
      sphere.presence * (material.stiffness_N_per_m + rate_per_s * damping_N_s_per_m);
  const double pressing_N = std::max(0.0, -contact.normal.dot(push.force_N));
  push.across_N_per_m =
      rate_per_s * material.friction * pressing_N / std::max(slip_m_s, material.slip_speed_m_s);
  push.by_depth = pressing_N > 0.0 ? Eigen::Vector3d(-push.force_N / pressing_N) : contact.normal;
  return true;
}

/// Solves for x, in place, by Gauss's elimination; the first `count` rows and columns of the matrix
/// count, and are spent. What a singular one gives is no number.
void eliminate(Matrix& matrix, int count, ModeDisplacements& x) {
  for (int j = 0; j < count; ++j) {
    int pivot = j;
    for (int i = j + 1; i < count; ++i)
      if (std::abs(matrix(i, j)) > std::abs(matrix(pivot, j))) pivot = i;
    if (pivot != j) {
      matrix.row(j).swap(matrix.row(pivot));
      std::swap(x[j], x[pivot]);
    }
    const double inverse = 1.0 / matrix(j, j);
    for (int i = j + 1; i < count; ++i) {
      const double share = inverse * matrix(i, j);
      for (int k = j + 1; k < count; ++k) matrix(i, k) -= share * matrix(j, k);
      x[i] -= share * x[j];
    }
  }
  for (int j = count - 1; j >= 0; --j) {
    for (int k = j + 1; k < count; ++k) x[j] -= matrix(j, k) * x[k];
    x[j] /= matrix(j, j);
  }
}

/// A response's laws, scaled: displacements are offset + root * unknown.
struct Scaling {
  ModeDisplacements root = ModeDisplacements::Zero(), offset = root, own_push = root;

  explicit Scaling(const ModeResponse& response) {
    for (std::size_t i = 0; i < response.count; ++i) {
      const display::ModeLaw& law = response.laws[i];
      const auto mode = static_cast<Eigen::Index>(i);
      root[mode] = std::sqrt(law.compliance);
      offset[mode] = law.offset;
      own_push[mode] = law.push;
    }
  }
  /// Of the unknowns, by their own scale.
  [[nodiscard]] ModeDisplacements residual(const ModeDisplacements& push,
                                           const ModeDisplacements& at) const {
    return (root.array() > 0.0)
        .select(root.cwiseProduct(push - own_push) - (at - offset).cwiseQuotient(root), 0.0);
  }
};

}  // namespace

/// What pushes the modes of touched spheres.
class Pushes {
 public:
  ModeDisplacements push;
  double softening;          // of the scene's own resistance, by normals that turn
  double stiffness_N_per_m;  // of the stiffest contact that there may be

  /// root: of the modes' compliance, to which the equations are scaled.
  void take(const TouchedSpheres& touched, const ModeDisplacements& root) {
    root_ = root;
    for (std::size_t i = 0; i < touched.response_count; ++i)
      parts_[i] = touched.responses[i].transpose().cast<double>();
  }
  void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) const {
    for (std::size_t i = 0; i < touched.count; ++i) {
      TouchedSphere& sphere = touched.spheres[i];
      if (sphere.response == 0) continue;
      const auto response = parts_[sphere.response - 1].transpose();
      place(motion, response * motion.displacements, response * motion.drift_per_s, sphere,
            touched.to_body_m(sphere));
    }
  }
  void evaluate(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                std::span<const PlacedToolSphere> tool, const ToolPose& pose, double rate_per_s) {
    push.setZero();
    softening = stiffness_N_per_m = 0.0;
    count_ = 0;
    for (const TouchedSphere& sphere : touched.all()) {
      if (sphere.response == 0 || sphere.material >= scene.material_count) continue;
      stiffness_N_per_m = std::max(stiffness_N_per_m,
                                   std::max(1.0, sphere.presence) *
                                       double{scene.materials[sphere.material].stiffness_N_per_m});
      Push& one = pushes_[count_];
      if (!push_on(scene, sphere, tool, pose, rate_per_s, one)) continue;
      ++count_;
      one.response = sphere.response - 1;
      const Part& part = parts_[one.response];
      push += part * one.force_N;
      softening += one.force_N.norm() * (root_.asDiagonal() * part).squaredNorm() /
                   (tool[sphere.tool_sphere].radius_m + sphere.radius_m);
    }
  }

  /// Solves (1 + what resists) x = residual for x, by as many equations as there are modes, or
  /// directions in which contacts resist if these are fewer [Woodbury].
  [[nodiscard]] ModeDisplacements solve(int modes, const ModeDisplacements& residual) {
    rows_count_ = 0;
    for (std::size_t i = 0; i < count_; ++i) add_rows(pushes_[i]);
    return rows_count_ < modes ? solve_by_rows(residual) : solve_by_modes(modes, residual);
  }

 private:
  using Rows = Eigen::Matrix<double, kModes, 3 * TouchedSpheres::kResponseCapacity>;

  /// What resists is the sum of pushed felt^T: how the push changes by what moves.
  void add_rows(const Push& one) {
    const Part part = root_.asDiagonal() * parts_[one.response];
    const auto add = [&](const Eigen::Vector3d& pushed, const Eigen::Vector3d& felt, double by) {
      pushed_.col(rows_count_) = by * (part * pushed);
      felt_.col(rows_count_++) = part * felt;
    };
    add(one.by_depth, one.normal, one.along_N_per_m);
    if (!(one.across_N_per_m > 0.0)) return;
    const Eigen::Vector3d across = one.normal.unitOrthogonal();
    add(across, across, one.across_N_per_m);
    add(one.normal.cross(across), one.normal.cross(across), one.across_N_per_m);
  }
  ModeDisplacements solve_by_modes(int modes, const ModeDisplacements& residual) {
    Matrix matrix = Matrix::Identity();
    for (int i = 0; i < rows_count_; ++i) matrix += pushed_.col(i) * felt_.col(i).transpose();
    ModeDisplacements x = residual;
    eliminate(matrix, modes, x);
    return x;
  }
  ModeDisplacements solve_by_rows(const ModeDisplacements& residual) {
    Matrix matrix = Matrix::Identity();
    ModeDisplacements held, x = residual;
    for (int i = 0; i < rows_count_; ++i) {
      held[i] = felt_.col(i).dot(residual);
      for (int j = 0; j < rows_count_; ++j) matrix(i, j) += felt_.col(i).dot(pushed_.col(j));
    }
    eliminate(matrix, rows_count_, held);
    for (int i = 0; i < rows_count_; ++i) x -= held[i] * pushed_.col(i);
    return x;
  }

  ModeDisplacements root_;
  std::array<Part, TouchedSpheres::kResponseCapacity> parts_;  // of each response
  std::array<Push, TouchedSpheres::kResponseCapacity> pushes_;
  std::size_t count_ = 0;
  Rows pushed_, felt_;
  int rows_count_ = 0;
};

void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) noexcept {
  for (std::size_t i = 0; i < touched.count; ++i) {
    TouchedSphere& sphere = touched.spheres[i];
    if (sphere.response != 0)
      give_way(motion, touched.response_of(sphere), sphere, touched.to_body_m(sphere));
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
    return take_step(snapshot, weights, period_s);
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
/// stands takes none, and shows them at rest.
void ModeResponse::take_step(const proto::SnapshotHeader& snapshot,
                             const display::SnapshotWeights& weights, double period_s) noexcept {
  const bool is_new = snapshot.snapshot_id != snapshot_id;
  const double step_share = weights.step_share;
  const auto show_velocities = [&](double rate_per_s) {
    motion.rate_per_s = rate_per_s;
    for (std::size_t i = 0; i < proto::kMaxModes; ++i)
      motion.drift_per_s[static_cast<Eigen::Index>(i)] =
          laws[i].compliance > 0.0
              ? rate_per_s * (to * snapshot.modes[i].displacement - starts[i].way) -
                    snapshot.modes[i].at_velocity / period_s
              : 0.0;
  };
  if (!is_new && !(step_share > to)) return show_velocities(0.0);
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
  show_velocities(to > from ? weights.pace / ((to - from) * period_s) : 0.0);
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

ResponseSolver::ResponseSolver() : pushes_(std::make_unique<Pushes>()) {}
ResponseSolver::~ResponseSolver() = default;

double ResponseSolver::solve(const proto::SceneHeader& scene,
                             std::span<const PlacedToolSphere> tool, const ToolPose& pose,
                             double radius_m, bool is_switch, TouchedSpheres& touched,
                             ModeResponse& response) noexcept {
  if (response.count == 0) return 0.0;
  const Scaling scaling(response);
  Pushes& now = *pushes_;
  now.take(touched, scaling.root);
  ModeDisplacements& at = response.motion.displacements;
  ModeDisplacements start = at, before = at;
  const double farthest_m = kMaxCompliantShift * radius_m;
  double change_N = 0.0, turn_share = 1.0, least = std::numeric_limits<double>::infinity();
  bool may_grow = true;
  for (int most = is_switch ? kMaxSwitchIterations : kMaxIterations; most > 0; --most) {
    now.evaluate(scene, touched, tool, pose, response.motion.rate_per_s);
    turn_share = now.softening > kMaxSoftening ? kMaxSoftening / now.softening : 1.0;
    const ModeDisplacements residual = scaling.residual(now.push, at);
    const double force_per_mode = now.stiffness_N_per_m * response.motion.largest_response;
    const double size = residual.norm();
    // No mode moves by more than its residual.
    if (force_per_mode * scaling.root.maxCoeff() * size <= kTolerance_N) {
      change_N = 0.0;
      break;
    }
    // Beyond the onset of a contact a step leads to and fro: what is better lies between. Once it
    // may lead deep, from where the next is short.
    if (size > least && !std::exchange(may_grow, false)) {
      at = 0.5 * (before + at);
      change_N *= 0.5;
    } else {
      const ModeDisplacements by =
          scaling.root.cwiseProduct(now.solve(static_cast<int>(response.count), residual));
      if (!by.allFinite()) break;
      least = size;
      before = at;
      if (is_switch) start = at;
      ModeDisplacements way = at + by - start;
      const double way_m = response.motion.largest_response * way.norm();
      if (way_m > farthest_m) way *= farthest_m / way_m;
      at = start + way;
      change_N = force_per_mode * (at - before).norm();
    }
    now.give_way(response.motion, touched);
    if (!(change_N > kTolerance_N)) break;
  }
  response.motion.turn_share = turn_share;
  return change_N > kTolerance_N ? change_N : 0.0;
}

}  // namespace stillgrid::rendering

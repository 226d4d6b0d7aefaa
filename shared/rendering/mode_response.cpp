#include "shared/rendering/mode_response.hpp"

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

/// A sphere's part in each mode; sqrt(m/N).
using Part = Eigen::Matrix<double, kModes, 3>;

/// What the tool does to a sphere, and how that falls as the sphere gives way.
struct Push {
  Eigen::Vector3d force_N, normal;
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
  push.across_N_per_m = rate_per_s * material.friction *
                        std::max(0.0, -contact.normal.dot(push.force_N)) /
                        std::max(slip_m_s, material.slip_speed_m_s);
  return true;
}

/// Solves for x, in place; of the first `count` rows and columns of a positive definite matrix the
/// lower half counts, and is spent.
void eliminate(Matrix& matrix, int count, ModeDisplacements& x) {
  ModeDisplacements inverse;
  for (int j = 0; j < count; ++j) {
    inverse[j] = 1.0 / matrix(j, j);
    for (int i = j + 1; i < count; ++i) {
      const double share = inverse[j] * matrix(i, j);
      matrix.col(i) -= share * matrix.col(j);
      x[i] -= share * x[j];
    }
  }
  for (int j = count - 1; j >= 0; --j) {
    for (int i = j + 1; i < count; ++i) x[j] -= matrix(i, j) * x[i];
    x[j] *= inverse[j];
  }
}

/// What pushes the modes of touched spheres.
class Pushes {
 public:
  ModeDisplacements push;
  double softening;          // of the scene's own resistance, by normals that turn
  double stiffness_N_per_m;  // of the stiffest contact that there may be

  /// root: of the modes' compliance, to which the equations are scaled.
  Pushes(const TouchedSpheres& touched, const ModeDisplacements& root) : root_(root) {
    for (std::size_t i = 0; i < touched.response_count; ++i)
      parts_[i] = touched.responses[i].transpose().cast<double>();
  }
  void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) const {
    for (std::size_t i = 0; i < touched.count; ++i) {
      TouchedSphere& sphere = touched.spheres[i];
      if (sphere.response == 0) continue;
      place(motion, parts_[sphere.response - 1].transpose() * motion.displacements, sphere);
    }
  }
  void evaluate(const proto::SceneHeader& scene, const TouchedSpheres& touched,
                std::span<const PlacedToolSphere> tool, const ToolPose& pose, double rate_per_s) {
    push.setZero();
    softening = stiffness_N_per_m = 0.0;
    count_ = 0;
    for (const TouchedSphere& sphere : touched.all()) {
      if (sphere.response == 0 || sphere.material >= scene.material_count) continue;
      stiffness_N_per_m =
          std::max(stiffness_N_per_m, double{scene.materials[sphere.material].stiffness_N_per_m});
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

  /// What resists is the sum of row row^T: the root of the contact's resistance, by its part.
  void add_rows(const Push& one) {
    const Part part = root_.asDiagonal() * parts_[one.response];
    const double along = std::sqrt(one.along_N_per_m), across = std::sqrt(one.across_N_per_m);
    const ModeDisplacements by_normal = (along - across) * (part * one.normal);
    if (!(across > 0.0)) {
      rows_.col(rows_count_++) = by_normal;
      return;
    }
    for (int axis = 0; axis < 3; ++axis)
      rows_.col(rows_count_++) = across * part.col(axis) + one.normal[axis] * by_normal;
  }
  ModeDisplacements solve_by_modes(int modes, const ModeDisplacements& residual) {
    while (rows_count_ % 3 != 0) rows_.col(rows_count_++).setZero();
    Matrix matrix = Matrix::Identity();
    for (int i = 0; i < rows_count_; i += 3) {  // the lower half, in blocks
      const Part three = rows_.middleCols<3>(i);
      matrix.leftCols<4>() += three.lazyProduct(three.topRows<4>().transpose());
      matrix.block<8, 4>(4, 4) +=
          three.bottomRows<8>().lazyProduct(three.middleRows<4>(4).transpose());
      matrix.block<4, 4>(8, 8) +=
          three.bottomRows<4>().lazyProduct(three.bottomRows<4>().transpose());
    }
    ModeDisplacements x = residual;
    eliminate(matrix, modes, x);
    return x;
  }
  ModeDisplacements solve_by_rows(const ModeDisplacements& residual) {
    Matrix matrix = Matrix::Identity();
    ModeDisplacements held, x = residual;
    for (int i = 0; i < rows_count_; ++i) {
      held[i] = rows_.col(i).dot(residual);
      for (int j = 0; j <= i; ++j) matrix(i, j) += rows_.col(i).dot(rows_.col(j));
    }
    eliminate(matrix, rows_count_, held);
    for (int i = 0; i < rows_count_; ++i) x -= held[i] * rows_.col(i);
    return x;
  }

  ModeDisplacements root_;
  std::array<Part, TouchedSpheres::kResponseCapacity> parts_;  // of each response
  std::array<Push, TouchedSpheres::kResponseCapacity> pushes_;
  std::size_t count_ = 0;
  Rows rows_;
  int rows_count_ = 0;
};

}  // namespace

void give_way(const display::ModeMotion& motion, TouchedSpheres& touched) noexcept {
  for (std::size_t i = 0; i < touched.count; ++i) {
    TouchedSphere& sphere = touched.spheres[i];
    if (sphere.response != 0)
      place(motion, touched.response_of(sphere).cast<double>() * motion.displacements, sphere);
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
  for (std::size_t i = 0; i < proto::kMaxModes; ++i) {
    const display::ModeLaw before = laws[i];
    laws[i] =
        i < count ? display::mode_law(snapshot.modes[i], weights.step_share) : display::ModeLaw{};
    auto& displacement = motion.displacements[static_cast<Eigen::Index>(i)];
    displacement = laws[i].compliance > 0.0 ? displacement + laws[i].offset - before.offset : 0.0;
  }
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
  Pushes now(touched, root);
  double change_N = 0.0;
  const int most = is_switch ? kMaxSwitchIterations : kMaxIterations;
  for (int iteration = 0; iteration < most; ++iteration) {
    if (is_switch) start = response.motion.displacements;
    now.evaluate(scene, touched, tool, pose, response.motion.rate_per_s);
    response.motion.turn_share =
        now.softening > kMaxSoftening ? kMaxSoftening / now.softening : 1.0;
    ModeDisplacements residual = ModeDisplacements::Zero();
    for (Eigen::Index i = 0; i < count; ++i)
      if (root[i] > 0.0)
        residual[i] = root[i] * (now.push[i] - own_push[i]) -
                      (response.motion.displacements[i] - offset[i]) / root[i];
    const double force_per_mode = now.stiffness_N_per_m * response.motion.largest_response;
    // No mode moves by more than its residual.
    if (force_per_mode * root.maxCoeff() * residual.norm() <= kTolerance_N) return 0.0;
    const ModeDisplacements by = root.cwiseProduct(now.solve(static_cast<int>(count), residual));
    if (!by.allFinite()) break;
    const ModeDisplacements before = response.motion.displacements;
    ModeDisplacements way = before + by - start;
    const double way_m = response.motion.largest_response * way.norm();
    if (way_m > farthest_m) way *= farthest_m / way_m;
    response.motion.displacements = start + way;
    change_N = force_per_mode * (response.motion.displacements - before).norm();
    now.give_way(response.motion, touched);
    if (!(change_N > kTolerance_N)) return 0.0;
  }
  return change_N;
}

}  // namespace stillgrid::rendering

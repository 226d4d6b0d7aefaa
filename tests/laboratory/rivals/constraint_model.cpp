#include "tests/laboratory/rivals/constraint_model.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::laboratory {
namespace {

constexpr std::size_t kMaxConstraints = 16;
constexpr int kMaxIterations = 100;
/// Of the forces, that the last iteration changes at most.
constexpr double kTolerance = 1e-9;

}  // namespace

void ConstraintModel::find_constraints(const LocalScene& scene, const PlacedTool& sampled) {
  constraints_.clear();
  const auto add = [&](const rendering::ToolContact& contact, std::uint32_t material,
                       std::uint32_t tool_sphere, int sphere) {
    const double stiffness_N_per_m =
        rendering::contact_material(scene.fixed, material).stiffness_N_per_m;
    if (!(stiffness_N_per_m > 0.0) || !contact.normal.allFinite() ||
        !std::isfinite(contact.depth_m))
      return;
    constraints_.push_back({tool_sphere, contact.normal, sampled.spheres[tool_sphere].position_m,
                            -contact.depth_m, stiffness_N_per_m, sphere});
  };
  const auto patch = scene.patch.all();
  for (std::size_t i = 0; i < patch.size(); ++i)
    if (patch[i].material < scene.fixed.material_count)
      add(rendering::contact_with(patch[i], sampled.spheres[patch[i].tool_sphere]),
          patch[i].material, patch[i].tool_sphere,
          i < scene.moving ? static_cast<int>(patch[i].number) : -1);
  for (std::uint32_t i = 0; i < scene.fixed.plane_count; ++i)
    for (std::uint32_t tool_sphere = 0; tool_sphere < sampled.spheres.size(); ++tool_sphere)
      add(rendering::contact_with(scene.fixed.planes[i], sampled.spheres[tool_sphere]),
          scene.fixed.planes[i].material, tool_sphere, -1);
  std::stable_sort(constraints_.begin(), constraints_.end(),
                   [](const Constraint& a, const Constraint& b) { return a.gap_m < b.gap_m; });
  if (constraints_.size() > kMaxConstraints) constraints_.resize(kMaxConstraints);
}

void ConstraintModel::update(const LocalScene& scene, const PlacedTool& sampled, const PlacedTool&,
                             bool) noexcept {
  find_constraints(scene, sampled);
  std::vector<ShippedSteps::Push> pushes;
  std::vector<Eigen::Index> pushed;
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    if (constraints_[i].sphere < 0) continue;
    // What the tool presses gives way against the normal.
    pushes.push_back({static_cast<std::size_t>(constraints_[i].sphere), -constraints_[i].normal});
    pushed.push_back(static_cast<Eigen::Index>(i));
  }
  const auto count = static_cast<Eigen::Index>(constraints_.size());
  compliance_m_per_N_.setZero(count, count);
  compliance_m_per_N_(pushed, pushed) = steps_.compliance_m_per_N(scene.state_time_ns, pushes);

  // The step's own forces: its springs act at its end.
  forces_N_.resize(count);
  Eigen::VectorXd gaps_m(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Constraint& constraint = constraints_[static_cast<std::size_t>(i)];
    gaps_m[i] = constraint.gap_m;
    forces_N_[i] = constraint.stiffness_N_per_m * std::max(0.0, -constraint.gap_m);
  }
  free_gaps_m_ = gaps_m - compliance_m_per_N_ * forces_N_;
  for (Eigen::Index i = 0; i < count; ++i)
    compliance_m_per_N_(i, i) += 1.0 / constraints_[static_cast<std::size_t>(i)].stiffness_N_per_m;
}

/// Projected Gauss-Seidel, from the forces before.
void ConstraintModel::solve(const Eigen::VectorXd& gaps_m) noexcept {
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double change_N = 0.0;
    for (Eigen::Index i = 0; i < gaps_m.size(); ++i) {
      const double left_m = gaps_m[i] + compliance_m_per_N_.row(i).dot(forces_N_);
      const double force_N = std::max(0.0, forces_N_[i] - left_m / compliance_m_per_N_(i, i));
      change_N = std::max(change_N, std::abs(force_N - forces_N_[i]));
      forces_N_[i] = force_N;
    }
    if (!(change_N > kTolerance * (1.0 + forces_N_.lpNorm<Eigen::Infinity>()))) break;
  }
}

rendering::ToolForce ConstraintModel::force(const LocalScene&, const PlacedTool& tool) noexcept {
  Eigen::VectorXd gaps_m = free_gaps_m_;
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    const Constraint& constraint = constraints_[i];
    gaps_m[static_cast<Eigen::Index>(i)] += constraint.normal.dot(
        tool.spheres[constraint.tool_sphere].position_m - constraint.sampled_m);
  }
  rendering::ToolForce sum;
  if (!gaps_m.allFinite()) return sum;
  solve(gaps_m);
  for (std::size_t i = 0; i < constraints_.size(); ++i) {
    const Constraint& constraint = constraints_[i];
    const double force_N = forces_N_[static_cast<Eigen::Index>(i)];
    if (!(force_N > 0.0)) continue;
    const rendering::PlacedToolSphere& sphere = tool.spheres[constraint.tool_sphere];
    const Eigen::Vector3d point_m = sphere.position_m - sphere.radius_m * constraint.normal;
    sum.force_N += force_N * constraint.normal;
    sum.torque_N_m += (point_m - tool.pose.position_m).cross(force_N * constraint.normal);
    sum.stiffness_N_per_m +=
        constraint.stiffness_N_per_m * constraint.normal * constraint.normal.transpose();
    ++sum.contacts;
  }
  return sum;
}

}  // namespace stillgrid::laboratory

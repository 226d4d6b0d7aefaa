#include "shared/dynamics/implicit_springs.hpp"

#include <algorithm>
#include <cmath>

#include "shared/dynamics/at.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr double kShortestLine_m = 1e-150;  // lines below it have no direction

double product(const Vector4& a, const Vector4& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

}  // namespace

ImplicitSprings::ImplicitSprings(const Description& description) {
  for (const Description::Spring& spring : description.springs)
    all_.push_back({spring.a,
                    spring.b,
                    spring.rest_length_m,
                    spring.stiffness_N_per_m,
                    spring.damping_N_s_per_m,
                    {},
                    {}});
  for (const Description::Joint& joint : description.joints)
    if (joint.rest_length_m > 0.0)
      all_.push_back({joint.a.node,
                      joint.b.node,
                      joint.rest_length_m,
                      joint.stiffness_N_per_m,
                      joint.damping_N_s_per_m,
                      {},
                      {}});
  springs_ = all_;
}

void ImplicitSprings::leave_out(std::span<const std::uint8_t> sleeping_nodes) {
  springs_.clear();
  for (const Spring& spring : all_)
    if (sleeping_nodes[at(spring.a)] == 0 || sleeping_nodes[at(spring.b)] == 0)
      springs_.push_back(spring);
}

void ImplicitSprings::start(std::span<const Vector4> positions_m) {
  for (Spring& spring : springs_) {
    spring.line_m = positions_m[at(spring.b)] - positions_m[at(spring.a)];
    spring.line_m.w = std::sqrt(product(spring.line_m, spring.line_m));
  }
}

/// The slope across a spring is that of its pull; a push would make it negative, and is left out.
void ImplicitSprings::add_impulses(std::span<const Vector4> positions_m, double h,
                                   Motions& impulses) {
  for (Spring& spring : springs_) {
    Vector4 line = positions_m[at(spring.b)] - positions_m[at(spring.a)];
    line.w = std::sqrt(product(line, line));
    const double k = spring.stiffness_N_per_m, c = spring.damping_N_s_per_m;
    const double pull = h * k * (line.w - spring.rest_m) + c * (line.w - spring.line_m.w);
    const double length = std::max(line.w, kShortestLine_m);
    Vector4 direction = (1.0 / length) * line;
    direction.w = 0.0;
    impulses[at(spring.a)] = impulses[at(spring.a)] + pull * direction;
    impulses[at(spring.b)] = impulses[at(spring.b)] - pull * direction;
    const double along = h * h * k + h * c;
    const double across = std::min(along, std::max(0.0, h * pull / length));
    spring.along_root = std::sqrt(along - across) * direction;
    spring.along_root.w = across;
  }
}

void ImplicitSprings::multiply(const Motions& velocities, Motions& sums) const {
  for (const Spring& spring : springs_) {
    const Vector4 opens = velocities[at(spring.b)] - velocities[at(spring.a)];
    Vector4 change =
        spring.along_root.w * opens + product(spring.along_root, opens) * spring.along_root;
    change.w = 0.0;
    sums[at(spring.b)] = sums[at(spring.b)] + change;
    sums[at(spring.a)] = sums[at(spring.a)] - change;
  }
}

void ImplicitSprings::add_blocks(MassBlocks& blocks) const {
  for (const Spring& spring : springs_) {
    const Eigen::Vector3d root = spring.along_root.vector();
    const Eigen::Matrix3d slope =
        spring.along_root.w * Eigen::Matrix3d::Identity() + root * root.transpose();
    blocks.nodes[at(spring.a)] += slope;
    blocks.nodes[at(spring.b)] += slope;
  }
}

double ImplicitSprings::damping_J(std::span<const Vector4> positions_m, double h) const {
  double sum_J = 0.0;
  for (const Spring& spring : springs_) {
    const Vector4 line = positions_m[at(spring.b)] - positions_m[at(spring.a)];
    const double change = std::sqrt(product(line, line)) - spring.line_m.w;
    sum_J += spring.damping_N_s_per_m / h * change * change;
  }
  return sum_J;
}

}  // namespace stillgrid::dynamics

// What contacts ask of bodies and nodes at most, and how these respond to what is left.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_server/bodies/rotation.hpp"
#include "sim_server/dynamics/contacts/contact_movers.hpp"

namespace stillgrid::dynamics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The inverse of [linear, coupled^T; coupled, turning], by blocks: closed forms of 3 x 3 cost a
/// tenth of a factorisation of 6 x 6.
void invert(Matrix6& matrix) {
  const Matrix3d coupled = matrix.bottomLeftCorner<3, 3>();
  const Matrix3d linear = matrix.topLeftCorner<3, 3>().inverse();
  const Matrix3d shared = coupled.lazyProduct(linear);
  const Matrix3d turn =
      (matrix.bottomRightCorner<3, 3>() - shared.lazyProduct(coupled.transpose())).inverse();
  const Matrix3d cross = -turn.lazyProduct(shared);
  matrix.bottomRightCorner<3, 3>() = turn;
  matrix.bottomLeftCorner<3, 3>() = cross;
  matrix.topRightCorner<3, 3>() = cross.transpose();
  matrix.topLeftCorner<3, 3>() = linear - shared.transpose().lazyProduct(cross);
}

/// How much impulse a change of the end velocity may ask for at most, N s per m/s, of a sum of
/// velocities of such weights: its square is at most the sum of their squares times weights /
/// weight. Across the normal, while it sticks, no more than along it.
struct AskedSlopes {
  double across_kg, more_kg;  // more: along the normal
  Vector3d normal;
  double spring_share;
};

/// Of a lane; none if nothing may push there.
bool slopes_of(const ContactRows& rows, std::size_t lane, double substep_s, AskedSlopes& slopes) {
  const double normal_kg = rows.normal_bound_kg[lane], weights = rows.weights[lane];
  if (!(normal_kg > 0.0)) return false;
  slopes.across_kg = weights * rows.across_bound_kg[lane];
  slopes.more_kg = weights * (normal_kg - rows.across_bound_kg[lane]);
  slopes.normal = ContactRows::get(rows.normal, lane);
  slopes.spring_share = 0.25 * substep_s * substep_s * rows.stiffness_N_per_m[lane] / normal_kg;
  return true;
}

}  // namespace

void ContactMovers::widen(int point) {
  if (point == 0) return;
  const std::size_t place = static_cast<std::size_t>(point) - 1;
  if (place < rigid_movers_.size()) {
    rigid_responses_[place].is_widened = true;
    return;
  }
  const SoftPoint& soft = soft_[place - rigid_movers_.size()];
  for (std::size_t i = 0; i < static_cast<std::size_t>(soft.node_count); ++i)
    if (const auto mover = static_cast<std::size_t>(soft.movers[i]); mover < node_movers_.size())
      node_responses_[mover].is_widened = true;
}

void ContactMovers::ask_body(std::size_t i, std::span<const ContactRows> rows, double substep_s) {
  Response<Matrix6>& response = rigid_responses_[i];
  response.bound = {};
  // With L the lever's cross matrix: L I, L n and L L^T = r^2 I - r r^T, in closed form.
  Matrix6& sum = response.matrix;
  sum.setZero();
  AskedSlopes slopes;
  for (const TouchSide side : sides_of(1 + i)) {
    const ContactRows& own = rows[side.lane / ContactRows::kLanes];
    const std::size_t lane = side.lane % ContactRows::kLanes;
    if (!slopes_of(own, lane, substep_s, slopes)) continue;
    const Vector3d arm_m = ContactRows::get(side.is_b ? own.arm_b_m : own.arm_a_m, lane);
    const Vector3d moment = arm_m.cross(slopes.normal), by_normal = slopes.more_kg * slopes.normal;
    sum.topLeftCorner<3, 3>() += by_normal * slopes.normal.transpose();
    sum.bottomLeftCorner<3, 3>() +=
        moment * by_normal.transpose() + slopes.across_kg * bodies::cross_matrix(arm_m);
    sum.bottomRightCorner<3, 3>() += (slopes.more_kg * moment) * moment.transpose() -
                                     (slopes.across_kg * arm_m) * arm_m.transpose();
    sum.diagonal().head<3>().array() += slopes.across_kg;
    sum.diagonal().tail<3>().array() += slopes.across_kg * arm_m.squaredNorm();
    response.bound.spring_share = std::max(response.bound.spring_share, slopes.spring_share);
  }
  const RigidMover& mover = rigid_movers_[i];
  const Matrix3d turning = mover.inverse_inertia_per_kg_m2 * sum.bottomRightCorner<3, 3>();
  response.bound.ratio = mover.inverse_mass_per_kg * sum.topLeftCorner<3, 3>().norm() +
                         std::sqrt(turning.cwiseProduct(turning.transpose()).sum());
  sum.topLeftCorner<3, 3>() += Matrix3d::Identity() / mover.inverse_mass_per_kg;
  sum.bottomRightCorner<3, 3>() += mover.inertia_kg_m2;
  invert(sum);
}

/// What contacts ask of nodes that ask for more; returns the largest share of springs in it.
double ContactMovers::ask_nodes(const ContactIsland& island, std::span<const ContactRows> rows,
                                double substep_s) {
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i)
    if (node_responses_[i].is_widened) node_responses_[i].matrix.setZero();
  double spring_share = 0.0;
  AskedSlopes slopes;
  const auto ask = [&](int point) {
    if (static_cast<std::size_t>(point) <= rigid_movers_.size()) return;
    const Matrix3d block = slopes.across_kg * Matrix3d::Identity() +
                           slopes.more_kg * slopes.normal * slopes.normal.transpose();
    ask_node(soft_[static_cast<std::size_t>(point) - 1 - rigid_movers_.size()], block);
    spring_share = std::max(spring_share, slopes.spring_share);
  };
  for (const ContactRows& own :
       rows.subspan(island.rows.first, island.rows.last - island.rows.first))
    for (std::size_t lane = 0; lane < ContactRows::kLanes; ++lane) {
      if (!slopes_of(own, lane, substep_s, slopes)) continue;
      ask(own.a[lane]);
      ask(own.b[lane]);
    }
  return spring_share;
}

void ContactMovers::ask_node(const SoftPoint& soft, const Matrix3d& block) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(soft.node_count); ++i) {
    const auto mover = static_cast<std::size_t>(soft.movers[i]);
    if (mover < node_movers_.size() && node_responses_[mover].is_widened)
      node_responses_[mover].matrix += std::abs(soft.weights[i]) * block;
  }
}

ResponseBound ContactMovers::make_responses(const ContactIsland& island,
                                            std::span<const ContactRows> rows, bool all,
                                            double substep_s, const ExplicitState& state,
                                            const Workers& workers) {
  if (!all)
    for (const ContactRows& own :
         rows.subspan(island.rows.first, island.rows.last - island.rows.first))
      for (std::size_t lane = 0; lane < ContactRows::kLanes; ++lane) {
        if (!(own.is_widened[lane] > 0.0)) continue;
        widen(own.a[lane]);
        widen(own.b[lane]);
      }
  const ContactIsland::Range& bodies = island.rigid;
  workers.for_each_chunk(
      bodies.last - bodies.first, kMoversAChunk, [&](std::size_t first, std::size_t last) {
        ResponseBound most;
        for (std::size_t i = bodies.first + first; i < bodies.first + last; ++i) {
          if (std::exchange(rigid_responses_[i].is_widened, false) || all)
            ask_body(i, rows, substep_s);
          most.add(rigid_responses_[i].bound);
        }
        bounds_[island.first_chunk + first / kMoversAChunk] = most;
      });
  ResponseBound most;
  for (std::size_t i = 0; i < bodies.last - bodies.first; i += kMoversAChunk)
    most.add(bounds_[island.first_chunk + i / kMoversAChunk]);
  if (island.nodes.first == island.nodes.last) return most;
  if (all)
    for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i)
      node_responses_[i].is_widened = true;
  most.spring_share = std::max(most.spring_share, ask_nodes(island, rows, substep_s));
  for (std::size_t i = island.nodes.first; i < island.nodes.last; ++i) {
    Response<Matrix3d>& response = node_responses_[i];
    if (std::exchange(response.is_widened, false)) {
      const double inverse_mass_per_kg =
          state.inverse_mass_per_kg[static_cast<std::size_t>(node_movers_[i].node)];
      response.bound.ratio = inverse_mass_per_kg * response.matrix.norm();
      response.matrix.diagonal().array() += 1.0 / inverse_mass_per_kg;
      response.matrix = response.matrix.inverse().eval();
    }
    most.add(response.bound);
  }
  return most;
}

}  // namespace stillgrid::dynamics

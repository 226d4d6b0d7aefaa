#include "sim_server/dynamics/contacts/contact_rows.hpp"

#include <algorithm>
#include <cmath>

namespace stillgrid::dynamics {
namespace {

/// So that nothing over nothing is nothing.
constexpr double kTiny = 1e-300;

double larger(double a, double b) {
  return a > b ? a : b;
}
double smaller(double a, double b) {
  return a < b ? a : b;
}

}  // namespace

void ContactRows::set(std::size_t lane, const SubstepContact& contact, const Eigen::Vector3d& given,
                      double substep_s) {
  const collision::ContactMaterial& material = contact.material;
  const double damper = material.damping_N_s_per_m / substep_s;
  const double both = material.stiffness_N_per_m + damper;
  Eigen::Vector3d across_m_s = contact.start_velocity_m_s;
  across_m_s -= contact.normal.dot(across_m_s) * contact.normal;
  const Eigen::Vector3d start =
      contact.is_viscous
          ? Eigen::Vector3d(0.5 * across_m_s)
          : both * (contact.stretch_m + 0.5 * substep_s * across_m_s) - damper * contact.stretch_m;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    normal[i][lane] = contact.normal[axis];
    given_m_s[i][lane] = given[axis];
    from[i][lane] = start[axis];
  }
  depth_m[lane] = contact.depth_m;
  start_m[lane] = start_depth_m(contact, substep_s);
  spring_N_per_m[lane] = material.stiffness_N_per_m;
  damper_N_per_m[lane] = damper;
  friction[lane] = material.friction;
  by[lane] = contact.is_viscous ? 0.5 : 0.5 * substep_s * both;
  least_m_s[lane] = contact.is_viscous ? material.slip_speed_m_s : -1.0;
  const double spring_kg = 0.25 * substep_s * substep_s * material.stiffness_N_per_m;
  const double damper_kg = 0.5 * substep_s * material.damping_N_s_per_m;
  normal_slope_kg[lane] = spring_kg + damper_kg;
  across_slope_kg[lane] = contact.is_viscous ? 0.5 * substep_s : 2.0 * spring_kg + damper_kg;
  normal_bound_kg[lane] = across_bound_kg[lane] = 0.0;
}

bool ContactRows::evaluate(std::span<const ContactPoint> velocities,
                           std::span<ContactPoint> impulses, double substep_s) {
  Vector velocity_m_s;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const ContactPoint& p = velocities[static_cast<std::size_t>(a[lane])];
    const ContactPoint& q = velocities[static_cast<std::size_t>(b[lane])];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = i < 2 ? i + 1 : 0, k = i > 0 ? i - 1 : 2;
      velocity_m_s[i][lane] =
          p.linear[i] + (p.angular[j] * arm_a_m[k][lane] - p.angular[k] * arm_a_m[j][lane]) -
          (q.linear[i] + (q.angular[j] * arm_b_m[k][lane] - q.angular[k] * arm_b_m[j][lane])) -
          given_m_s[i][lane];
    }
  }
  find_impulses(velocity_m_s, substep_s);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    ContactPoint& p = impulses[static_cast<std::size_t>(a[lane])];
    ContactPoint& q = impulses[static_cast<std::size_t>(b[lane])];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = i < 2 ? i + 1 : 0, k = i > 0 ? i - 1 : 2;
      p.linear[i] += impulse_N_s[i][lane];
      q.linear[i] -= impulse_N_s[i][lane];
      p.angular[i] +=
          arm_a_m[j][lane] * impulse_N_s[k][lane] - arm_a_m[k][lane] * impulse_N_s[j][lane];
      q.angular[i] -=
          arm_b_m[j][lane] * impulse_N_s[k][lane] - arm_b_m[k][lane] * impulse_N_s[j][lane];
    }
  }
  return widen_bounds();
}

/// The law, without branches.
void ContactRows::find_impulses(const Vector& velocity_m_s, double substep_s) {
  const double half_s = 0.5 * substep_s;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const double nx = normal[0][i], ny = normal[1][i], nz = normal[2][i];
    const double ux = velocity_m_s[0][i], uy = velocity_m_s[1][i], uz = velocity_m_s[2][i];
    const double apart_m_s = nx * ux + ny * uy + nz * uz;
    const double start = start_m[i], end = depth_m[i] - half_s * apart_m_s;
    const double high = larger(start, end), low = smaller(start, end);
    const double deepest = larger(high, 0.0), outside = smaller(low, 0.0);
    const double crossing =
        deepest * deepest / (2.0 * (deepest - outside) + (deepest > 0.0 ? 0.0 : 1.0));
    const double mean = low > 0.0 ? 0.5 * (start + end) : crossing;
    const double spring = spring_N_per_m[i] * mean;
    const double damper = damper_N_per_m[i] * larger(0.0, larger(end, 0.0) - larger(start, 0.0));
    const double most = friction[i] * (spring + damper);
    const double rx = from[0][i] + by[i] * (ux - apart_m_s * nx);
    const double ry = from[1][i] + by[i] * (uy - apart_m_s * ny);
    const double rz = from[2][i] + by[i] * (uz - apart_m_s * nz);
    const double size = std::sqrt(rx * rx + ry * ry + rz * rz);
    const double yields = least_m_s[i] > 0.0 ? least_m_s[i] : most;
    const double share = most / larger(larger(size, yields), kTiny);
    const double push = spring + damper;
    impulse_N_s[0][i] = substep_s * (push * nx - share * rx);
    impulse_N_s[1][i] = substep_s * (push * ny - share * ry);
    impulse_N_s[2][i] = substep_s * (push * nz - share * rz);
    spring_N[i] = spring;
    damper_N[i] = damper;
    held[i] = share;
  }
}

bool ContactRows::widen_bounds() {
  bool is_bounded = true;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const double across_kg = held[i] * across_slope_kg[i];
    if (!(spring_N[i] + damper_N[i] > 0.0) ||
        (normal_slope_kg[i] <= normal_bound_kg[i] && across_kg <= across_bound_kg[i]))
      continue;
    is_bounded = false;
    normal_bound_kg[i] = normal_slope_kg[i];
    // Less than a chord to the origin asks for, twice: it may yet stick more.
    across_bound_kg[i] =
        least_m_s[i] > 0.0 ? 2.0 * across_kg : std::min(2.0 * across_kg, across_slope_kg[i]);
  }
  return is_bounded;
}

}  // namespace stillgrid::dynamics

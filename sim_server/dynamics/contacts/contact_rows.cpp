// What contacts push at velocities, and what they did in the end.
#include "sim_server/dynamics/contacts/contact_rows.hpp"

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/contacts/contact_rows.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include "sim_server/dynamics/contacts/row_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

/// Whether impulses may change by no more than their bounds say; else the bounds are new.
HWY_INLINE bool WidenBounds(ContactRows& rows, std::size_t i, Vec push, Vec held) {
  const Tag d;
  const Vec normal = Get(rows.normal_slope_kg, i), normal_bound = Get(rows.normal_bound_kg, i);
  const Vec most = Get(rows.across_slope_kg, i), across_bound = Get(rows.across_bound_kg, i);
  const Vec across = hn::Mul(held, most);
  const auto is_wider = hn::And(hn::Gt(push, hn::Zero(d)),
                                hn::Or(hn::Gt(normal, normal_bound), hn::Gt(across, across_bound)));
  Put(hn::IfThenElseZero(is_wider, Number(1.0)), rows.is_widened, i);
  if (hn::AllFalse(d, is_wider)) return true;
  // Less than a chord to the origin asks for, twice: it may yet stick more.
  const Vec twice = hn::Add(across, across);
  const Vec wide =
      hn::IfThenElse(hn::Gt(Get(rows.slip_m_s, i), hn::Zero(d)), twice, hn::Min(twice, most));
  Put(hn::IfThenElse(is_wider, normal, normal_bound), rows.normal_bound_kg, i);
  Put(hn::IfThenElse(is_wider, wide, across_bound), rows.across_bound_kg, i);
  return false;
}

/// The law, without branches.
HWY_INLINE bool Evaluate(ContactRows& rows, const ContactPoint* HWY_RESTRICT velocities,
                         ContactPush* HWY_RESTRICT pushes, Vec step_s, std::size_t i) {
  const Tag d;
  const Vec zero = hn::Zero(d);
  Vec nx, ny, nz, ux, uy, uz, fx, fy, fz;
  RelativeVelocity(rows, velocities, i, ux, uy, uz);
  Get(rows.normal, i, nx, ny, nz);
  const Vec apart = Dot(nx, ny, nz, ux, uy, uz);
  const Vec start = Get(rows.start_m, i);
  const Vec end = hn::Sub(Get(rows.depth_m, i), hn::Mul(hn::Mul(Number(0.5), step_s), apart));
  const Vec low = hn::Min(start, end), deepest = hn::Max(hn::Max(start, end), zero);
  const Vec outside = hn::Min(low, zero), apart_m = hn::Sub(deepest, outside);
  const Vec crossing = hn::Div(
      hn::Mul(deepest, deepest),
      hn::Add(hn::Add(apart_m, apart_m), hn::IfThenElse(hn::Gt(deepest, zero), zero, Number(1.0))));
  const Vec mean =
      hn::IfThenElse(hn::Gt(low, zero), hn::Mul(Number(0.5), hn::Add(start, end)), crossing);
  const Vec spring = hn::Mul(Get(rows.stiffness_N_per_m, i), mean);
  const Vec deepens = hn::Sub(hn::Max(end, zero), hn::Max(start, zero));
  const Vec damper =
      hn::Div(hn::Mul(Get(rows.damping_N_s_per_m, i), hn::Max(zero, deepens)), step_s);
  const Vec push = hn::Add(spring, damper), most = hn::Mul(Get(rows.friction, i), push);
  const Vec by = Get(rows.by, i), slip = Get(rows.slip_m_s, i);
  Get(rows.from, i, fx, fy, fz);
  fx = hn::Add(fx, hn::Mul(by, hn::Sub(ux, hn::Mul(apart, nx))));
  fy = hn::Add(fy, hn::Mul(by, hn::Sub(uy, hn::Mul(apart, ny))));
  fz = hn::Add(fz, hn::Mul(by, hn::Sub(uz, hn::Mul(apart, nz))));
  const Vec size = hn::Sqrt(Dot(fx, fy, fz, fx, fy, fz));
  const Vec yields = hn::IfThenElse(hn::Gt(slip, zero), slip, most);
  // So that nothing over nothing is nothing.
  const Vec share = hn::Div(most, hn::Max(hn::Max(size, yields), Number(1e-300)));
  fx = hn::Mul(step_s, hn::Sub(hn::Mul(push, nx), hn::Mul(share, fx)));
  fy = hn::Mul(step_s, hn::Sub(hn::Mul(push, ny), hn::Mul(share, fy)));
  fz = hn::Mul(step_s, hn::Sub(hn::Mul(push, nz), hn::Mul(share, fz)));
  Put(fx, fy, fz, rows.impulse_N_s, i);
  Put(spring, rows.spring_N, i);
  Put(damper, rows.damper_N, i);
  PackedVector linear[4], moment_a[4], moment_b[4];
  Vec rx, ry, rz;
  Spread(fx, fy, fz, linear);
  Get(rows.arm_a_m, i, rx, ry, rz);
  Spread(Minor(ry, fz, rz, fy), Minor(rz, fx, rx, fz), Minor(rx, fy, ry, fx), moment_a);
  Get(rows.arm_b_m, i, rx, ry, rz);
  Spread(Minor(ry, fz, rz, fy), Minor(rz, fx, rx, fz), Minor(rx, fy, ry, fx), moment_b);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k)
    pushes[i + k] = {linear[k], moment_a[k], moment_b[k]};
  return WidenBounds(rows, i, push, share);
}

bool EvaluateRows(std::span<ContactRows> all, std::span<const ContactPoint> velocities,
                  std::span<ContactPush> pushes, double substep_s) {
  const Tag d;
  const Vec step_s = Number(substep_s);
  bool is_bounded = true;
  for (std::size_t row = 0; row < all.size(); ++row)
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d))
      is_bounded =
          Evaluate(all[row], velocities.data(), &pushes[row * kLanes], step_s, i) && is_bounded;
  return is_bounded;
}

/// Energy of the contacts' springs.
HWY_INLINE Vec SpringEnergy(Vec stiffness, Vec depth) {
  const Vec pressed = hn::Max(hn::Zero(Tag()), depth);
  return hn::Mul(hn::Mul(hn::Mul(Number(0.5), stiffness), pressed), pressed);
}

/// What has been stretched further, as contact::sticking_force() has it; returns what it holds.
HWY_INLINE Vec Stretch(ContactRows& rows, std::size_t i, Vec push, Vec wx, Vec wy, Vec wz,
                       Vec step_s) {
  const Tag d;
  const Vec zero = hn::Zero(d), stiffness = Get(rows.stiffness_N_per_m, i);
  const Vec damper = hn::Div(Get(rows.damping_N_s_per_m, i), step_s);
  const Vec both = hn::Add(stiffness, damper), friction = Get(rows.friction, i);
  const auto sticks = hn::And(hn::And(hn::Gt(push, zero), hn::Gt(friction, zero)),
                              hn::And(hn::Gt(both, zero), hn::Lt(Get(rows.slip_m_s, i), zero)));
  Vec x, y, z;
  Get(rows.stretch_m, i, x, y, z);
  const Vec dx = hn::Mul(damper, x), dy = hn::Mul(damper, y), dz = hn::Mul(damper, z);
  x = hn::Sub(hn::Mul(both, hn::Add(x, wx)), dx);
  y = hn::Sub(hn::Mul(both, hn::Add(y, wy)), dy);
  z = hn::Sub(hn::Mul(both, hn::Add(z, wz)), dz);
  const Vec size = hn::Sqrt(Dot(x, y, z, x, y, z)), most = hn::Mul(friction, push);
  const Vec share = hn::IfThenElse(hn::Gt(size, most), hn::Div(most, size), Number(1.0));
  x = hn::IfThenElseZero(sticks, hn::Div(hn::Add(dx, hn::Mul(share, x)), both));
  y = hn::IfThenElseZero(sticks, hn::Div(hn::Add(dy, hn::Mul(share, y)), both));
  z = hn::IfThenElseZero(sticks, hn::Div(hn::Add(dz, hn::Mul(share, z)), both));
  Put(x, y, z, rows.stretch_m, i);
  return hn::Mul(hn::Mul(Number(0.5), stiffness), Dot(x, y, z, x, y, z));
}

HWY_INLINE void AddTo(Lane& sum, std::size_t i, Vec more) {
  Put(hn::Add(Get(sum, i), more), sum, i);
}

void EndRows(std::span<ContactRows> all, std::span<const ContactPoint> velocities, double substep_s,
             RowFlow& flow) {
  const Tag d;
  const Vec step_s = Number(substep_s), half = Number(0.5);
  for (ContactRows& rows : all) {
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
      Vec nx, ny, nz, ux, uy, uz, sx, sy, sz, px, py, pz;
      RelativeVelocity(rows, velocities.data(), i, ux, uy, uz);
      Get(rows.normal, i, nx, ny, nz);
      const Vec end_m = hn::Sub(Get(rows.depth_m, i),
                                hn::Mul(hn::Mul(half, step_s), Dot(nx, ny, nz, ux, uy, uz)));
      Get(rows.begin_m_s, i, sx, sy, sz);
      ux = hn::Mul(half, hn::Add(sx, ux));
      uy = hn::Mul(half, hn::Add(sy, uy));
      uz = hn::Mul(half, hn::Add(sz, uz));
      const Vec apart = Dot(nx, ny, nz, ux, uy, uz), way = hn::Mul(step_s, apart);
      const Vec spring = Get(rows.spring_N, i), damper = Get(rows.damper_N, i);
      const Vec push = hn::Add(spring, damper), stiffness = Get(rows.stiffness_N_per_m, i);
      const Vec holds_J = Stretch(rows, i, push, hn::Mul(step_s, hn::Sub(ux, hn::Mul(apart, nx))),
                                  hn::Mul(step_s, hn::Sub(uy, hn::Mul(apart, ny))),
                                  hn::Mul(step_s, hn::Sub(uz, hn::Mul(apart, nz))), step_s);
      Get(rows.impulse_N_s, i, px, py, pz);
      const Vec across_J = hn::Sub(Dot(px, py, pz, ux, uy, uz), hn::Mul(push, way));
      const Vec change_J =
          hn::Sub(SpringEnergy(stiffness, end_m), SpringEnergy(stiffness, Get(rows.start_m, i)));
      AddTo(flow.damping_J, i, hn::Neg(hn::Mul(damper, way)));
      AddTo(flow.friction_J, i, hn::Sub(hn::Sub(Get(rows.held_J, i), holds_J), across_J));
      AddTo(flow.spring_change_J, i, change_J);
      AddTo(flow.unsolved_J, i, hn::Add(change_J, hn::Mul(spring, way)));
      Get(rows.given_m_s, i, sx, sy, sz);  // work against what is moved from outside
      AddTo(flow.given_J, i, Dot(px, py, pz, sx, sy, sz));
      flow.struck = flow.struck || !hn::AllFalse(d, hn::Gt(push, hn::Zero(d)));
    }
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(EvaluateRows);
HWY_EXPORT(EndRows);

}  // namespace

void ContactRows::set_material(std::size_t lane, const collision::ContactMaterial& material,
                               bool is_viscous) {
  stiffness_N_per_m[lane] = material.stiffness_N_per_m;
  damping_N_s_per_m[lane] = material.damping_N_s_per_m;
  friction[lane] = material.friction;
  slip_m_s[lane] = is_viscous ? material.slip_speed_m_s : -1.0;
}

bool evaluate_rows(std::span<ContactRows> rows, std::span<const ContactPoint> velocities,
                   std::span<ContactPush> pushes, double substep_s) {
  return HWY_DYNAMIC_DISPATCH(EvaluateRows)(rows, velocities, pushes, substep_s);
}

void end_rows(std::span<ContactRows> rows, std::span<const ContactPoint> velocities,
              double substep_s, RowFlow& flow) {
  HWY_DYNAMIC_DISPATCH(EndRows)(rows, velocities, substep_s, flow);
}

}  // namespace stillgrid::dynamics
#endif

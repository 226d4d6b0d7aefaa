#include "sim_server/dynamics/contacts/contact_rows.hpp"

#include <array>
#include <cstddef>

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/contacts/contact_rows.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Four lanes at most, as many as a point's vector has. No product is fused with a sum, so that
// every target rounds alike.
using Tag = hn::CappedTag<double, 4>;
using Vec = hn::Vec<Tag>;
using Lane = ContactRows::Lane;
using Vector = ContactRows::Vector;
constexpr std::size_t kLanes = ContactRows::kLanes;

HWY_INLINE Vec Number(double value) {
  return hn::Set(Tag(), value);
}
HWY_INLINE Vec Get(const Lane& lane, std::size_t i) {
  return hn::Load(Tag(), lane.data() + i);
}
HWY_INLINE void Put(Vec v, Lane& lane, std::size_t i) {
  hn::Store(v, Tag(), lane.data() + i);
}
HWY_INLINE void Get(const Vector& from, std::size_t i, Vec& x, Vec& y, Vec& z) {
  x = Get(from[0], i);
  y = Get(from[1], i);
  z = Get(from[2], i);
}
HWY_INLINE void Put(Vec x, Vec y, Vec z, Vector& to, std::size_t i) {
  Put(x, to[0], i);
  Put(y, to[1], i);
  Put(z, to[2], i);
}
HWY_INLINE Vec Dot(Vec ax, Vec ay, Vec az, Vec bx, Vec by, Vec bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}
/// a * d - b * c.
HWY_INLINE Vec Minor(Vec a, Vec d, Vec b, Vec c) {
  return hn::Sub(hn::Mul(a, d), hn::Mul(b, c));
}

/// The vectors of as many lanes as a register has, coordinate by coordinate.
template <class Place>
HWY_INLINE void Gather(const Place& place, std::size_t i, Vec& x, Vec& y, Vec& z) {
  const Tag d;
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  const Vec v0 = hn::Load(d, &place(i)->x), v1 = hn::Load(d, &place(i + 1)->x);
  const Vec v2 = hn::Load(d, &place(i + 2)->x), v3 = hn::Load(d, &place(i + 3)->x);
  const Vec even0 = hn::InterleaveLower(d, v0, v1), even1 = hn::InterleaveLower(d, v2, v3);
  x = hn::ConcatLowerLower(d, even1, even0);
  y = hn::ConcatLowerLower(d, hn::InterleaveUpper(d, v2, v3), hn::InterleaveUpper(d, v0, v1));
  z = hn::ConcatUpperUpper(d, even1, even0);
#else
  std::array<PackedVector, 4> lanes;
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) lanes[k] = *place(i + k);
  Vec zero;
  hn::LoadInterleaved4(d, &lanes[0].x, x, y, z, zero);
#endif
}

/// The other way round.
HWY_INLINE void Spread(Vec x, Vec y, Vec z, PackedVector* HWY_RESTRICT lanes) {
  hn::StoreInterleaved4(x, y, z, hn::Zero(Tag()), Tag(), &lanes[0].x);
}

template <bool adds>
HWY_INLINE void Change(PackedVector& sum, const PackedVector& by) {
  const Tag d;
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
    const Vec own = hn::Load(d, &sum.x + k), more = hn::Load(d, &by.x + k);
    hn::Store(adds ? hn::Add(own, more) : hn::Sub(own, more), d, &sum.x + k);
  }
}

/// linear + angular x arm.
template <class Point>
HWY_INLINE void VelocityOf(const Point& point, const Vector& arm_m, std::size_t i, Vec& x, Vec& y,
                           Vec& z) {
  Vec wx, wy, wz, rx, ry, rz;
  Gather([&](std::size_t k) { return &point(k).linear; }, i, x, y, z);
  Gather([&](std::size_t k) { return &point(k).angular; }, i, wx, wy, wz);
  Get(arm_m, i, rx, ry, rz);
  x = hn::Add(x, Minor(wy, rz, wz, ry));
  y = hn::Add(y, Minor(wz, rx, wx, rz));
  z = hn::Add(z, Minor(wx, ry, wy, rx));
}

/// Of a's point of contact from b's.
HWY_INLINE void RelativeVelocity(const ContactRows& rows, const ContactPoint* HWY_RESTRICT points,
                                 std::size_t i, Vec& x, Vec& y, Vec& z) {
  Vec bx, by, bz, gx, gy, gz;
  VelocityOf(
      [&](std::size_t k) -> auto& { return points[rows.a[k]]; }, rows.arm_a_m, i, x, y, z);
  VelocityOf(
      [&](std::size_t k) -> auto& { return points[rows.b[k]]; }, rows.arm_b_m, i, bx, by, bz);
  Get(rows.given_m_s, i, gx, gy, gz);
  x = hn::Sub(hn::Sub(x, bx), gx);
  y = hn::Sub(hn::Sub(y, by), gy);
  z = hn::Sub(hn::Sub(z, bz), gz);
}

/// Normal, depth and arms; what the given side moves at.
HWY_INLINE void PlaceGeometry(ContactRows& rows, const ContactSphere* HWY_RESTRICT spheres,
                              std::size_t i, Vec& nx, Vec& ny, Vec& nz) {
  const Tag d;
  const auto other = [&](std::size_t k) {
    return rows.sphere_b[k] >= 0 ? &spheres[rows.sphere_b[k]].position_m : &rows.other_m[k];
  };
  const PackedVector none;
  const auto other_arm = [&](std::size_t k) {
    return rows.sphere_b[k] >= 0 ? &spheres[rows.sphere_b[k]].arm_m : &none;
  };
  Vec x, y, z, bx, by, bz;
  Gather([&](std::size_t k) { return &spheres[rows.sphere_a[k]].position_m; }, i, x, y, z);
  Gather(other, i, bx, by, bz);
  x = hn::Sub(x, bx);
  y = hn::Sub(y, by);
  z = hn::Sub(z, bz);
  Get(rows.normal, i, nx, ny, nz);
  const auto is_plane = hn::Gt(Get(rows.is_plane, i), hn::Zero(d));
  const Vec far =
      hn::IfThenElse(is_plane, Dot(nx, ny, nz, x, y, z), hn::Sqrt(Dot(x, y, z, x, y, z)));
  // Concentric spheres push along any one direction: up.
  const auto is_apart = hn::Ge(far, Number(1e-12));
  nx = hn::IfThenElse(is_plane, nx, hn::IfThenElseZero(is_apart, hn::Div(x, far)));
  ny = hn::IfThenElse(is_plane, ny, hn::IfThenElseZero(is_apart, hn::Div(y, far)));
  nz = hn::IfThenElse(is_plane, nz, hn::IfThenElse(is_apart, hn::Div(z, far), Number(1.0)));
  Put(nx, ny, nz, rows.normal, i);
  const Vec both = Get(rows.distance_m, i), radius = Get(rows.radius_m, i);
  Put(hn::Sub(both, far), rows.depth_m, i);
  // From the centres to the point of contact.
  const Vec reach = hn::IfThenElse(is_plane, radius, hn::Mul(hn::Div(radius, both), far));
  const Vec rest = hn::Sub(far, reach);
  Vec ax, ay, az;
  Gather([&](std::size_t k) { return &spheres[rows.sphere_a[k]].arm_m; }, i, ax, ay, az);
  const Vec turns_a = Get(rows.turns_a, i), turns_b = Get(rows.turns_b, i);
  Put(hn::Mul(turns_a, hn::Sub(ax, hn::Mul(reach, nx))),
      hn::Mul(turns_a, hn::Sub(ay, hn::Mul(reach, ny))),
      hn::Mul(turns_a, hn::Sub(az, hn::Mul(reach, nz))), rows.arm_a_m, i);
  Gather(other_arm, i, ax, ay, az);
  const Vec tx = hn::Mul(rest, nx), ty = hn::Mul(rest, ny), tz = hn::Mul(rest, nz);
  Put(hn::Mul(turns_b, hn::Add(ax, tx)), hn::Mul(turns_b, hn::Add(ay, ty)),
      hn::Mul(turns_b, hn::Add(az, tz)), rows.arm_b_m, i);
  // Along the normal the way counts, across it what the velocity says.
  Vec gx, gy, gz, sx, sy, sz;
  Get(rows.given_across_m_s, i, gx, gy, gz);
  Get(rows.given_spin_rad_s, i, sx, sy, sz);
  gx = hn::Add(gx, Minor(sy, tz, sz, ty));
  gy = hn::Add(gy, Minor(sz, tx, sx, tz));
  gz = hn::Add(gz, Minor(sx, ty, sy, tx));
  Get(rows.given_along_m_s, i, sx, sy, sz);
  const Vec along = Dot(nx, ny, nz, hn::Sub(sx, gx), hn::Sub(sy, gy), hn::Sub(sz, gz));
  Put(hn::Add(gx, hn::Mul(along, nx)), hn::Add(gy, hn::Mul(along, ny)),
      hn::Add(gz, hn::Mul(along, nz)), rows.given_m_s, i);
}

/// The stretch carried along with a contact that turned: from `before` to the new normal by the
/// shortest turn, and about it by the angle, as long as it was.
HWY_INLINE void Carry(Vec bx, Vec by, Vec bz, Vec nx, Vec ny, Vec nz, Vec turned, Vec& x, Vec& y,
                      Vec& z) {
  const Tag d;
  const Vec zero = hn::Zero(d), one = Number(1.0);
  const Vec before = Dot(x, y, z, x, y, z);
  const Vec px = Minor(by, z, bz, y), py = Minor(bz, x, bx, z), pz = Minor(bx, y, by, x);
  x = hn::Add(x, hn::Mul(turned, px));
  y = hn::Add(y, hn::Mul(turned, py));
  z = hn::Add(z, hn::Mul(turned, pz));
  // Opposite normals are no contact that turned.
  const Vec along = hn::Add(one, Dot(bx, by, bz, nx, ny, nz));
  const Vec tilt =
      hn::IfThenElseZero(hn::Gt(along, Number(1e-3)), hn::Div(Dot(nx, ny, nz, x, y, z), along));
  x = hn::Sub(x, hn::Mul(tilt, hn::Add(bx, nx)));
  y = hn::Sub(y, hn::Mul(tilt, hn::Add(by, ny)));
  z = hn::Sub(z, hn::Mul(tilt, hn::Add(bz, nz)));
  const Vec out = Dot(nx, ny, nz, x, y, z);
  x = hn::Sub(x, hn::Mul(out, nx));
  y = hn::Sub(y, hn::Mul(out, ny));
  z = hn::Sub(z, hn::Mul(out, nz));
  const Vec after = Dot(x, y, z, x, y, z);
  const Vec share = hn::IfThenElseZero(hn::Gt(after, zero), hn::Sqrt(hn::Div(before, after)));
  x = hn::Mul(share, x);
  y = hn::Mul(share, y);
  z = hn::Mul(share, z);
}

void PlaceRows(std::span<ContactRows> all, std::span<const ContactSphere> spheres,
               std::span<const ContactPoint> velocities, double substep_s) {
  const Tag d;
  const Vec half_s = Number(0.5 * substep_s), zero = hn::Zero(d);
  for (ContactRows& rows : all) {
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d)) {
      Vec ox, oy, oz, nx, ny, nz, ux, uy, uz, wx, wy, wz, vx, vy, vz, sx, sy, sz;
      Get(rows.normal, i, ox, oy, oz);
      PlaceGeometry(rows, spheres.data(), i, nx, ny, nz);
      RelativeVelocity(rows, velocities.data(), i, ux, uy, uz);
      Put(ux, uy, uz, rows.begin_m_s, i);
      Gather(
          [&](std::size_t k) { return &velocities[static_cast<std::size_t>(rows.a[k])].angular; },
          i, wx, wy, wz);
      Gather(
          [&](std::size_t k) { return &velocities[static_cast<std::size_t>(rows.b[k])].angular; },
          i, vx, vy, vz);
      const Vec spin = hn::Add(Dot(nx, ny, nz, wx, wy, wz), Dot(nx, ny, nz, vx, vy, vz));
      const Vec stiffness = Get(rows.stiffness_N_per_m, i);
      const Vec damping = Get(rows.damping_N_s_per_m, i);
      Get(rows.stretch_m, i, sx, sy, sz);
      Put(hn::Mul(hn::Mul(Number(0.5), stiffness), Dot(sx, sy, sz, sx, sy, sz)), rows.held_J, i);
      Carry(ox, oy, oz, nx, ny, nz, hn::Mul(half_s, spin), sx, sy, sz);
      Put(sx, sy, sz, rows.stretch_m, i);
      const Vec apart = Dot(nx, ny, nz, ux, uy, uz);
      Put(hn::Add(Get(rows.depth_m, i), hn::Mul(half_s, apart)), rows.start_m, i);
      // What holds across: both (s + h/2 v) - damper s = k s + by v, and of the tool v / 2.
      const auto is_viscous = hn::Gt(Get(rows.slip_m_s, i), zero);
      const Vec spring_kg = hn::Mul(hn::Mul(half_s, half_s), stiffness);
      const Vec damper_kg = hn::Mul(half_s, damping);
      const Vec by =
          hn::IfThenElse(is_viscous, Number(0.5),
                         hn::Add(hn::Mul(half_s, stiffness), hn::Mul(Number(0.5), damping)));
      const Vec holds = hn::IfThenElse(is_viscous, zero, stiffness);
      Put(by, rows.by, i);
      Put(hn::Add(hn::Mul(holds, sx), hn::Mul(by, hn::Sub(ux, hn::Mul(apart, nx)))),
          hn::Add(hn::Mul(holds, sy), hn::Mul(by, hn::Sub(uy, hn::Mul(apart, ny)))),
          hn::Add(hn::Mul(holds, sz), hn::Mul(by, hn::Sub(uz, hn::Mul(apart, nz)))), rows.from, i);
      Put(hn::Add(spring_kg, damper_kg), rows.normal_slope_kg, i);
      Put(hn::IfThenElse(is_viscous, half_s, hn::Add(hn::Add(spring_kg, spring_kg), damper_kg)),
          rows.across_slope_kg, i);
      Put(zero, rows.normal_bound_kg, i);
      Put(zero, rows.across_bound_kg, i);
    }
  }
}

/// Whether impulses may change by no more than their bounds say; else the bounds are new.
HWY_INLINE bool WidenBounds(ContactRows& rows, std::size_t i, Vec push, Vec held) {
  const Tag d;
  const Vec normal = Get(rows.normal_slope_kg, i), normal_bound = Get(rows.normal_bound_kg, i);
  const Vec most = Get(rows.across_slope_kg, i), across_bound = Get(rows.across_bound_kg, i);
  const Vec across = hn::Mul(held, most);
  const auto is_wider = hn::And(hn::Gt(push, hn::Zero(d)),
                                hn::Or(hn::Gt(normal, normal_bound), hn::Gt(across, across_bound)));
  if (hn::AllFalse(d, is_wider)) return true;
  // Less than a chord to the origin asks for, twice: it may yet stick more.
  const Vec twice = hn::Add(across, across);
  const Vec wide =
      hn::IfThenElse(hn::Gt(Get(rows.slip_m_s, i), hn::Zero(d)), twice, hn::Min(twice, most));
  Put(hn::IfThenElse(is_wider, normal, normal_bound), rows.normal_bound_kg, i);
  Put(hn::IfThenElse(is_wider, wide, across_bound), rows.across_bound_kg, i);
  return false;
}

/// The law, without branches; adds the impulses to both sides.
HWY_INLINE bool Evaluate(ContactRows& rows, const ContactPoint* HWY_RESTRICT velocities,
                         ContactPoint* HWY_RESTRICT impulses, Vec step_s, std::size_t i) {
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
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    ContactPoint &p = impulses[rows.a[i + k]], &q = impulses[rows.b[i + k]];
    Change<true>(p.linear, linear[k]);
    Change<true>(p.angular, moment_a[k]);
    Change<false>(q.linear, linear[k]);
    Change<false>(q.angular, moment_b[k]);
  }
  return WidenBounds(rows, i, push, share);
}

bool EvaluateRows(std::span<ContactRows> all, std::span<const ContactPoint> velocities,
                  std::span<ContactPoint> impulses, double substep_s) {
  const Tag d;
  const Vec step_s = Number(substep_s);
  bool is_bounded = true;
  for (ContactRows& rows : all)
    for (std::size_t i = 0; i < kLanes; i += hn::Lanes(d))
      is_bounded = Evaluate(rows, velocities.data(), impulses.data(), step_s, i) && is_bounded;
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
HWY_EXPORT(PlaceRows);
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

void place_rows(std::span<ContactRows> rows, std::span<const ContactSphere> spheres,
                std::span<const ContactPoint> velocities, double substep_s) {
  HWY_DYNAMIC_DISPATCH(PlaceRows)(rows, spheres, velocities, substep_s);
}

bool evaluate_rows(std::span<ContactRows> rows, std::span<const ContactPoint> velocities,
                   std::span<ContactPoint> impulses, double substep_s) {
  return HWY_DYNAMIC_DISPATCH(EvaluateRows)(rows, velocities, impulses, substep_s);
}

void end_rows(std::span<ContactRows> rows, std::span<const ContactPoint> velocities,
              double substep_s, RowFlow& flow) {
  HWY_DYNAMIC_DISPATCH(EndRows)(rows, velocities, substep_s, flow);
}

}  // namespace stillgrid::dynamics
#endif

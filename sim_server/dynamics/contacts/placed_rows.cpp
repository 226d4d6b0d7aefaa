// Where contacts are in the middle of a substep, and what of them it does not change.
#include "sim_server/dynamics/contacts/contact_rows.hpp"

// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim_server/dynamics/contacts/placed_rows.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include "sim_server/dynamics/contacts/row_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

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

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {
namespace {
HWY_EXPORT(PlaceRows);

}  // namespace

void place_rows(std::span<ContactRows> rows, std::span<const ContactSphere> spheres,
                std::span<const ContactPoint> velocities, double substep_s) {
  HWY_DYNAMIC_DISPATCH(PlaceRows)(rows, spheres, velocities, substep_s);
}

}  // namespace stillgrid::dynamics
#endif

// The law of a contact; included once for every instruction set that Highway knows.
#if defined(STILLGRID_CONTACT_LAW) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_CONTACT_LAW
#undef STILLGRID_CONTACT_LAW
#else
#define STILLGRID_CONTACT_LAW
#endif

#include "shared/dynamics/columns-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

constexpr float kApart_m = -1e6F;  // depth of a lane that is not solved

HWY_INLINE bool IsSolved(const ContactRow& row, std::size_t i) {
  return !hn::AllTrue(Floats(), hn::Eq(Get(row.depth_m, i), All(kApart_m)));
}

/// Normals and depths at the middle of the substep; false where no lane may touch within it.
HWY_INLINE bool Locate(ContactRow& row, const RowPlace& place, const ContactBodies& bodies,
                       bool is_plane, std::size_t i) {
  Column3 normal;
  const SpherePlace* const places = bodies.places.data();
  const std::int32_t *const a = place.sphere_a + i, *const b = place.sphere_b + i;
  Column3 moved_a, moved_b;
  Column reach_a, reach_b = All(0.0F), distance;
  GetColumns([=](std::size_t k) { return places[a[k]].moved_m; }, moved_a, reach_a);
  Column3 apart = Get(place.apart_m, i) + moved_a;
  if (is_plane) {
    normal = Get(row.normal, i);
    distance = Dot(apart, normal);
  } else {
    GetColumns([=](std::size_t k) { return places[b[k]].moved_m; }, moved_b, reach_b);
    apart = apart - moved_b;
    distance = hn::Sqrt(Dot(apart, apart));
    normal = (All(1.0F) / hn::Max(distance, All(1e-12F))) * apart;
  }
  const Column radii = Get(place.radii_m, i);
  const Column depth = radii - distance;
  const auto may_touch = hn::Or(hn::Gt(depth + reach_a + reach_b, All(0.0F)),
                                hn::Gt(Get(row.push_impulse_N_s, i), All(0.0F)));
  // Else the neighbours in a vector would decide whether a lane is solved.
  Put(hn::IfThenElse(may_touch, depth, All(kApart_m)), row.depth_m, i);
  if (hn::AllFalse(Floats(), may_touch)) return false;
  Put(normal, row.normal, i);
  Put(distance / hn::Max(radii, All(1e-12F)), row.lever, i);
  return true;
}

/// Turns the stretch of friction with the normal, and by turn_rad about it. Keeps its length.
HWY_INLINE Column3 TurnedStretch(RowPlace& place, const Column3& normal, Column turn_rad,
                                 std::size_t i) {
  const Column3 before = Get(place.stretch_m, i);
  const Column3 tilted = before - Dot(before, normal) * normal;
  const Column3 across = tilted + turn_rad * Cross(normal, tilted);
  const Column was = Dot(before, before), is = hn::Max(Dot(across, across), All(1e-24F));
  const Column3 turned = hn::Min(All(2.0F), hn::Sqrt(was / is)) * across;
  Put(turned, place.stretch_m, i);
  return turned;
}

/// The equations of the substep. Friction is a spring at its mean stretch, with its damper.
HWY_INLINE void SetEquations(ContactRow& row, RowPlace& place, const Column3& velocity,
                             Column turn_rad_s, float h, std::size_t i) {
  const Column3 normal = Get(row.normal, i);
  const Column depth = Get(row.depth_m, i);
  const Column zero = All(0.0F), one = All(1.0F);
  const Column k = Get(place.stiffness_N_per_m, i), c = Get(place.damping_N_s_per_m, i);
  const Column mass = Get(row.normal_mass_per_kg, i);
  const Column u0 = Dot(velocity, normal);
  Put(depth + All(0.5F * h) * u0, row.start_m, i);
  const Column spring_part = All(0.25F * h * h) * k, damper_part = All(0.5F * h) * c;
  Put(All(0.5F * h) * k, row.spring_N_s_per_m, i);
  Put(c, row.damper_N_s_per_m, i);
  Put(one / (one + mass * spring_part), row.inverse_spring, i);
  Put(one / (one + mass * (spring_part + damper_part)), row.inverse_both, i);
  const Column3 stretch = TurnedStretch(place, normal, All(h) * turn_rad_s, i);
  const Column3 slip = velocity - u0 * normal;
  const auto sticks = hn::Eq(Get(row.viscous_s_per_m, i), zero);
  const Column slope = hn::IfThenElseZero(sticks, spring_part + damper_part);
  Put(slope, row.hold_slope_kg, i);
  Put((hn::IfThenElseZero(sticks, All(h) * k)) * stretch + slope * slip, row.held_impulse_N_s, i);
  const Column3 drag = Get(row.friction_impulse_N_s, i);
  Put(drag - Dot(drag, normal) * normal, row.friction_impulse_N_s, i);
}

/// Returns the impulse of a contact that deepens, and zero for others. Its force is the mean force
/// of spring and damper over the substep. end_m is the depth at the end without this impulse.
HWY_INLINE Column DeepeningPush(const ContactRow& row, Column end_m, Column per_impulse,
                                std::size_t i) {
  const Column zero = All(0.0F), start = Get(row.start_m, i);
  const Column inside = hn::Max(start, zero), outside = hn::Max(zero - start, zero);
  const Column spring = Get(row.spring_N_s_per_m, i), damper = Get(row.damper_N_s_per_m, i);
  const Column spring_part = per_impulse * spring, damper_part = per_impulse * damper;
  const Column inverse = Get(row.inverse_both, i);
  const Column sum =
      end_m - (All(1.0F) + damper_part) * outside - (spring_part - damper_part) * inside;
  Column end = inverse * sum, share = All(1.0F);
  const auto enters = hn::And(hn::Gt(outside, zero), hn::Gt(end_m, zero));
  if (!hn::AllFalse(Floats(), enters)) {
    const Column product = (All(1.0F) + (spring_part + damper_part)) * (end_m * outside);
    const Column root = hn::Sqrt(sum * sum + All(4.0F) * hn::Max(product, zero));
    end = hn::IfThenElse(enters, All(0.5F) * inverse * (sum + root), end);
    share = hn::IfThenElse(enters, end / hn::Max(end + outside, All(1e-12F)), share);
  }
  return hn::IfThenElseZero(hn::Gt(end, inside),
                            spring * (inside + share * end) + damper * (end - inside));
}

/// The normal impulse that the equations ask for, from the normal velocity without it. The damper
/// acts while the contact deepens.
HWY_INLINE Column SolvePush(const ContactRow& row, Column velocity, Column half_step,
                            std::size_t i) {
  const Column zero = All(0.0F), start = Get(row.start_m, i);
  const Column spring = Get(row.spring_N_s_per_m, i);
  const Column per_impulse = half_step * Get(row.normal_mass_per_kg, i);
  const Column end_m = Get(row.depth_m, i) - half_step * velocity;
  const Column spring_part = per_impulse * spring;
  const Column end = Get(row.inverse_spring, i) * (end_m - spring_part * start);
  Column alone = spring * (start + end);
  const auto touched = hn::Gt(start, zero), leaves = hn::And(touched, hn::Lt(end, zero));
  if (!hn::AllFalse(Floats(), leaves)) {
    const Column away = start - end_m;
    const Column recedes =
        All(0.5F) * (away + hn::Sqrt(away * away + All(4.0F) * spring_part * start * start));
    alone = hn::IfThenElse(leaves, spring * start * start / hn::Max(recedes, All(1e-12F)), alone);
  }
  const Column deepening = DeepeningPush(row, end_m, per_impulse, i);
  return hn::IfThenElse(hn::Gt(deepening, zero), deepening, hn::IfThenElseZero(touched, alone));
}

/// The friction impulse that the equations ask for, from the slip without it.
HWY_INLINE Column3 SolveDrag(const ContactRow& row, const Column3& slip, Column push,
                             std::size_t i) {
  const Column most = Get(row.friction, i) * push;
  const Column slope = Get(row.hold_slope_kg, i) + most * Get(row.viscous_s_per_m, i);
  const Column3 asked = (All(1.0F) / (All(1.0F) + Get(row.across_mass_per_kg, i) * slope)) *
                        (Get(row.held_impulse_N_s, i) + slope * slip);
  const Column size = hn::Sqrt(hn::Max(Dot(asked, asked), All(1e-30F)));
  // The sum makes a negative zero a positive one, so that states are equal byte by byte.
  return Column3{All(0.0F), All(0.0F), All(0.0F)} - hn::Min(All(1.0F), most / size) * asked;
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

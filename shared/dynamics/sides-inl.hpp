// The two sides of a row of contacts; included once for every instruction set that Highway knows.
#if defined(STILLGRID_SIDES) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLGRID_SIDES
#undef STILLGRID_SIDES
#else
#define STILLGRID_SIDES
#endif

#include "shared/dynamics/columns-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {

/// Arguments of a side besides its row.
struct SideContext {
  ContactBodies* bodies;
  RowList* list;
  std::size_t side;  // index into soft_sides or rigid_sides
  std::size_t lane;
};

HWY_INLINE void AddInverseMass(Column normal, Column across, ContactRow& row, std::size_t i) {
  Put(Get(row.normal_mass_per_kg, i) + normal, row.normal_mass_per_kg, i);
  Put(Get(row.across_mass_per_kg, i) + across, row.across_mass_per_kg, i);
}

/// Changes of velocity and spin of all lanes, to be added to movers lane by lane.
struct MoverChanges {
  alignas(64) float velocity[kColumnLanes][4], spin[kColumnLanes][4];
};
HWY_INLINE void AddFour(const float* HWY_RESTRICT from, float* HWY_RESTRICT to) {
  for (int k = 0; k < 4; ++k) to[k] += from[k];
}

/// Inverse share of a mover's mass that one of its contacts has: half of their number. Convergence
/// needs at least this. Larger numbers slow down modes in which impulses cancel out.
HWY_INLINE Column MassShare(Column contacts) {
  return hn::Max(All(1.0F), All(0.5F) * contacts);
}

/// Sign: +1 for side a, -1 for side b, on which the opposite impulse acts.
template <int Sign>
struct BallSide {
  static constexpr SideKind kKind = SideKind::kBall;
  Column3 velocity, spin;
  Column inverse_mass, contacts;
  MoverChanges changes;

  static HWY_INLINE const RowIndices& Movers(const ContactRow& row) {
    return Sign > 0 ? row.mover_a : row.mover_b;
  }
  HWY_INLINE void Load(const ContactRow& row, const SideContext& context) {
    const std::int32_t* const index = Movers(row) + context.lane;
    Mover* const movers = context.bodies->movers.data();
    GetColumns([=](std::size_t k) { return movers[index[k]].velocity_m_s; }, velocity,
               inverse_mass);
    GetColumns([=](std::size_t k) { return movers[index[k]].spin; }, spin, contacts);
  }
  HWY_INLINE void Store(const ContactRow& row, const SideContext& context) const {
    const std::int32_t* const index = Movers(row) + context.lane;
    Mover* const movers = context.bodies->movers.data();
    PutColumns(velocity, inverse_mass,
               [=](std::size_t k) { return movers[index[k]].velocity_m_s; });
    PutColumns(spin, contacts, [=](std::size_t k) { return movers[index[k]].spin; });
  }
  /// Afterwards Push() sums changes, which AddLane() adds to the mover of one lane.
  HWY_INLINE void Clear() { velocity = spin = {All(0.0F), All(0.0F), All(0.0F)}; }
  HWY_INLINE void ListChanges() {
    PutColumns(velocity, All(0.0F), [this](std::size_t k) { return changes.velocity[k]; });
    PutColumns(spin, All(0.0F), [this](std::size_t k) { return changes.spin[k]; });
  }
  HWY_INLINE void AddLane(const ContactRow& row, const SideContext& context, std::size_t k) const {
    Mover& mover = context.bodies->changes[static_cast<std::size_t>(Movers(row)[context.lane + k])];
    AddFour(changes.velocity[k], mover.velocity_m_s);
    AddFour(changes.spin[k], mover.spin);
  }
  HWY_INLINE Column3 AtContact(const Column3& normal, Column lever) const {
    const Column3 around = lever * Cross(spin, normal);
    return Sign > 0 ? velocity - around : velocity + around;
  }
  /// Half of the angular velocity along the normal: the stretch of friction turns with both sides.
  HWY_INLINE Column TurnRate(const RowPlace& place, const SideContext& context,
                             const Column3& normal) const {
    const std::int32_t* const index = (Sign > 0 ? place.sphere_a : place.sphere_b) + context.lane;
    const SphereArm* const arms = context.bodies->arms.data();
    Column3 arm;
    Column radius;
    GetColumns([=](std::size_t k) { return arms[index[k]].arm_m; }, arm, radius);
    return All(0.5F) / radius * Dot(spin, normal);
  }
  HWY_INLINE void Push(const Column3& impulse, const Column3& normal, Column lever) {
    const Column3 change = inverse_mass * impulse;
    velocity = Sign > 0 ? velocity + change : velocity - change;
    spin = spin - (All(2.5F) * lever) * Cross(normal, change);
  }
  HWY_INLINE void Prepare(ContactRow& row, const RowPlace&, const SideContext& context,
                          const Column3&, Column lever, bool in_turn) const {
    const Column share = in_turn ? inverse_mass : MassShare(contacts) * inverse_mass;
    AddInverseMass(share, share * (All(1.0F) + All(2.5F) * lever * lever), row, context.lane);
  }
};

template <int Sign>
struct RigidBodySide {
  static constexpr SideKind kKind = SideKind::kRigid;
  BallSide<Sign> motion;  // its spin is the angular velocity
  Column3 arm;
  Column xx, xy, xz, yy, yz, zz;  // inverse inertia

  HWY_INLINE void Load(const ContactRow& row, const SideContext& context) {
    motion.Load(row, context);
    arm = Get(context.list->rigid_sides[context.side].arm_m, context.lane);
    const std::int32_t* const index = BallSide<Sign>::Movers(row) + context.lane;
    const InverseInertia* const all = context.bodies->inverse_inertias.data();
    Column3 first, second;
    Column zero;
    GetColumns([=](std::size_t k) { return &all[index[k]].xx; }, first, zero);
    GetColumns([=](std::size_t k) { return &all[index[k]].yy; }, second, zero);
    xx = first.x, xy = first.y, xz = first.z;
    yy = second.x, yz = second.y, zz = second.z;
  }
  HWY_INLINE void Store(const ContactRow& row, const SideContext& context) const {
    motion.Store(row, context);
  }
  HWY_INLINE void Clear() { motion.Clear(); }
  HWY_INLINE void ListChanges() { motion.ListChanges(); }
  HWY_INLINE void AddLane(const ContactRow& row, const SideContext& context, std::size_t k) const {
    motion.AddLane(row, context, k);
  }
  HWY_INLINE Column3 Turn(const Column3& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z};
  }
  HWY_INLINE Column3 AtContact(const Column3&, Column) const {
    return motion.velocity + Cross(motion.spin, arm);
  }
  HWY_INLINE Column TurnRate(const RowPlace&, const SideContext&, const Column3& normal) const {
    return All(0.5F) * Dot(motion.spin, normal);
  }
  HWY_INLINE void Push(const Column3& impulse, const Column3&, Column) {
    const Column3 change = motion.inverse_mass * impulse, turn = Turn(Cross(arm, impulse));
    motion.velocity = Sign > 0 ? motion.velocity + change : motion.velocity - change;
    motion.spin = Sign > 0 ? motion.spin + turn : motion.spin - turn;
  }
  /// The trace of the inverse mass across the normal bounds its larger eigenvalue.
  HWY_INLINE void Prepare(ContactRow& row, const RowPlace& place, const SideContext& context,
                          const Column3& normal, Column lever, bool in_turn) {
    const std::int32_t* const index = (Sign > 0 ? place.sphere_a : place.sphere_b) + context.lane;
    const SphereArm* const arms = context.bodies->arms.data();
    Column radius;
    GetColumns([=](std::size_t k) { return arms[index[k]].arm_m; }, arm, radius);
    const Column3 out = (lever * radius) * normal;
    arm = Sign > 0 ? arm - out : arm + out;
    Put(arm, context.list->rigid_sides[context.side].arm_m, context.lane);
    const Column3 moment = Cross(arm, normal);
    const Column along = Dot(moment, Turn(moment));
    const Column trace = Dot(arm, arm) * (xx + yy + zz) - Dot(arm, Turn(arm));
    const Column share = in_turn ? All(1.0F) : MassShare(motion.contacts);
    AddInverseMass(share * (motion.inverse_mass + along),
                   share * (motion.inverse_mass + hn::Max(trace - along, All(0.0F))), row,
                   context.lane);
  }
};

template <int Sign>
struct SoftBodySide {
  static constexpr SideKind kKind = SideKind::kSoft;
  Column3 velocity[4];
  Column inverse_mass[4], weight[4], contacts[4];
  MoverChanges changes[4];

  HWY_INLINE void Load(const ContactRow&, const SideContext& context) {
    const SoftSide& side = context.list->soft_sides[context.side];
    Mover* const movers = context.bodies->movers.data();
    for (int node = 0; node < 4; ++node) {
      const std::int32_t* const index = side.node[node] + context.lane;
      GetColumns([=](std::size_t k) { return movers[index[k]].velocity_m_s; }, velocity[node],
                 inverse_mass[node]);
      Column3 spin;
      GetColumns([=](std::size_t k) { return movers[index[k]].spin; }, spin, contacts[node]);
      weight[node] = Get(side.weight[node], context.lane);
    }
  }
  HWY_INLINE void Clear() {
    for (Column3& v : velocity) v = {All(0.0F), All(0.0F), All(0.0F)};
  }
  HWY_INLINE void ListChanges() {
    for (int node = 0; node < 4; ++node)
      PutColumns(velocity[node], All(0.0F),
                 [this, node](std::size_t k) { return changes[node].velocity[k]; });
  }
  HWY_INLINE void AddLane(const ContactRow&, const SideContext& context, std::size_t k) const {
    const SoftSide& side = context.list->soft_sides[context.side];
    for (int node = 0; node < 4; ++node)
      AddFour(changes[node].velocity[k],
              context.bodies->changes[static_cast<std::size_t>(side.node[node][context.lane + k])]
                  .velocity_m_s);
  }
  HWY_INLINE Column3 AtContact(const Column3&, Column) const {
    return (weight[0] * velocity[0] + weight[1] * velocity[1]) +
           (weight[2] * velocity[2] + weight[3] * velocity[3]);
  }
  HWY_INLINE Column TurnRate(const RowPlace&, const SideContext&, const Column3&) const {
    return All(0.0F);
  }
  HWY_INLINE void Push(const Column3& impulse, const Column3&, Column) {
    for (int node = 0; node < 4; ++node) {
      const Column3 change = (weight[node] * inverse_mass[node]) * impulse;
      velocity[node] = Sign > 0 ? velocity[node] + change : velocity[node] - change;
    }
  }
  HWY_INLINE void Prepare(ContactRow& row, const RowPlace&, const SideContext& context,
                          const Column3&, Column, bool) const {
    Column sum = All(0.0F);
    for (int node = 0; node < 4; ++node)
      sum = sum + MassShare(contacts[node]) * weight[node] * weight[node] * inverse_mass[node];
    AddInverseMass(sum, sum, row, context.lane);
  }
};

struct PlaneSide {
  static constexpr SideKind kKind = SideKind::kPlane;
  HWY_INLINE void Clear() {}
  HWY_INLINE void ListChanges() {}
  HWY_INLINE void AddLane(const ContactRow&, const SideContext&, std::size_t) const {}
  HWY_INLINE void Load(const ContactRow&, const SideContext&) {}
  HWY_INLINE void Store(const ContactRow&, const SideContext&) const {}
  HWY_INLINE Column TurnRate(const RowPlace&, const SideContext&, const Column3&) const {
    return All(0.0F);
  }
  HWY_INLINE void Push(const Column3&, const Column3&, Column) {}
  HWY_INLINE void Prepare(ContactRow&, const RowPlace&, const SideContext&, const Column3&, Column,
                          bool) const {}
  HWY_INLINE Column3 AtContact(const Column3&, Column) const {
    return {All(0.0F), All(0.0F), All(0.0F)};
  }
};

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

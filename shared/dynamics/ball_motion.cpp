#include "shared/dynamics/ball_motion.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2)
// One code for every instruction set that Highway knows; the best is chosen when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shared/dynamics/ball_motion.cpp"
#include <hwy/foreach_target.h>  // first: highway.h depends on it
#include <hwy/highway.h>

#include <cmath>

#include "shared/dynamics/rigid_motion.hpp"

HWY_BEFORE_NAMESPACE();
namespace stillgrid::dynamics::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using BallTag = hn::CappedTag<double, 4>;

/// Calls visit(k) for the first of the lanes of each vector of four numbers.
template <class Visit>
HWY_INLINE void EachPart(const Visit& visit) {
  for (std::size_t k = 0; k < 4; k += hn::MaxLanes(BallTag())) visit(k);
}
HWY_INLINE hn::Vec<BallTag> Part(const Vector4& v, std::size_t k) {
  return hn::Load(BallTag(), &v.x + k);
}
HWY_INLINE hn::Vec<BallTag> Times(double s, hn::Vec<BallTag> v) {
  return hn::Mul(hn::Set(BallTag(), s), v);
}
HWY_INLINE void Store(hn::Vec<BallTag> v, Vector4& to, std::size_t k) {
  hn::Store(v, BallTag(), &to.x + k);
}
/// Rounds to floats; the fourth is kept as it is.
HWY_INLINE void StoreFloats(const Vector4& v, float* to) {
  const float fourth = to[3];
  EachPart([&](std::size_t k) HWY_ATTR {
    const hn::Rebind<float, BallTag> d;
    hn::StoreU(hn::DemoteTo(d, Part(v, k)), d, to + k);
  });
  to[3] = fourth;
}
/// to += s (now - float(before)).
HWY_INLINE void AddChange(const Vector4& before, const float* now, double s, Vector4& to) {
  EachPart([&](std::size_t k) HWY_ATTR {
    const BallTag d;
    const hn::Rebind<float, BallTag> f;
    const auto rounded = hn::DemoteTo(f, Part(before, k));
    const auto change = hn::PromoteTo(d, hn::Sub(hn::LoadU(f, now + k), rounded));
    Store(hn::Add(Part(to, k), Times(s, change)), to, k);
  });
}

void StartBalls(const BallList& balls, std::size_t first, std::size_t end, SceneState& state,
                ContactBodies& bodies, double substep_s, double falls_m) {
  const auto h = static_cast<float>(substep_s), falls = static_cast<float>(falls_m);
  for (std::size_t i = first; i < end; ++i) {
    const auto r = static_cast<std::size_t>(balls.rigid[i]);
    const Vector4 &velocity = state.rigid_velocity_m_s[r], &base = balls.base[i];
    Vector4 &position = state.rigid_position_m[r], moved, spin;
    EachPart([&](std::size_t k) HWY_ATTR {
      const auto now = hn::Add(Part(position, k), Times(0.5 * substep_s, Part(velocity, k)));
      Store(now, position, k);
      Store(hn::Sub(now, Part(base, k)), moved, k);
      Store(Times(balls.radius_m[i], Part(state.angular_velocity_rad_s[r], k)), spin, k);
    });
    Mover& mover = bodies.movers[balls.first_mover + i];
    StoreFloats(velocity, mover.velocity_m_s);
    StoreFloats(spin, mover.spin);
    SpherePlace& place = bodies.places[static_cast<std::size_t>(balls.place[i])];
    StoreFloats(moved, place.moved_m);
    const float x = mover.velocity_m_s[0], y = mover.velocity_m_s[1], z = mover.velocity_m_s[2];
    place.margin_m = h * std::sqrt(x * x + y * y + z * z) + falls;
  }
}

void KickBalls(const BallList& balls, std::size_t first, std::size_t end, const SceneState& state,
               ContactBodies& bodies, const Vector4& change_m_s) {
  for (std::size_t i = first; i < end; ++i) {
    Vector4 velocity;
    EachPart([&](std::size_t k) HWY_ATTR {
      const auto r = static_cast<std::size_t>(balls.rigid[i]);
      Store(hn::Add(Part(state.rigid_velocity_m_s[r], k), Part(change_m_s, k)), velocity, k);
    });
    StoreFloats(velocity, bodies.movers[balls.first_mover + i].velocity_m_s);
  }
}

void FinishBalls(const BallList& balls, std::size_t first, std::size_t end, SceneState& state,
                 const ContactBodies& bodies, double substep_s, const Vector4& change_m_s) {
  for (std::size_t i = first; i < end; ++i) {
    const auto r = static_cast<std::size_t>(balls.rigid[i]);
    const Mover& mover = bodies.movers[balls.first_mover + i];
    const double radius = balls.radius_m[i];
    Vector4 &velocity = state.rigid_velocity_m_s[r], &position = state.rigid_position_m[r];
    Vector4 &turning = state.angular_velocity_rad_s[r], spin;
    EachPart([&](std::size_t k) HWY_ATTR {
      Store(hn::Add(Part(velocity, k), Part(change_m_s, k)), velocity, k);
      Store(Times(radius, Part(turning, k)), spin, k);
    });
    AddChange(velocity, mover.velocity_m_s, 1.0, velocity);
    AddChange(spin, mover.spin, 1.0 / radius, turning);
    velocity.w = turning.w = 0.0;  // behind the vectors of a mover are other numbers
    EachPart([&](std::size_t k) HWY_ATTR {
      Store(hn::Add(Part(position, k), Times(0.5 * substep_s, Part(velocity, k))), position, k);
    });
  }
}

}  // namespace stillgrid::dynamics::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillgrid::dynamics {

HWY_EXPORT(StartBalls);
HWY_EXPORT(KickBalls);
HWY_EXPORT(FinishBalls);

namespace {

/// Calls work(first, end) for parts of the balls, by several threads where there are.
template <class Work>
void in_parts(const BallList& balls, const Work& work) {
  constexpr std::size_t kBallsAPart = 2048;  // fewer cost more than they share
  balls.sharing->for_each_chunk(balls.rigid.size(), kBallsAPart, work);
}

}  // namespace

void start_balls(const BallList& balls, SceneState& state, ContactBodies& bodies, double substep_s,
                 double falls_m) {
  in_parts(balls, [&](std::size_t first, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(StartBalls)(balls, first, end, state, bodies, substep_s, falls_m);
  });
}
void kick_balls(const BallList& balls, const SceneState& state, ContactBodies& bodies,
                const Vector4& change_m_s) {
  in_parts(balls, [&](std::size_t first, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(KickBalls)(balls, first, end, state, bodies, change_m_s);
  });
}
void finish_balls(const BallList& balls, SceneState& state, const ContactBodies& bodies,
                  double substep_s, const Vector4& change_m_s) {
  in_parts(balls, [&](std::size_t first, std::size_t end) {
    HWY_DYNAMIC_DISPATCH(FinishBalls)(balls, first, end, state, bodies, substep_s, change_m_s);
  });
}

void turn_balls(const BallList& balls, SceneState& state, double duration_s) {
  in_parts(balls, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const auto r = static_cast<std::size_t>(balls.rigid[i]);
      state.orientation[r] = Vector4(turned(state.orientation[r].quaternion(),
                                            state.angular_velocity_rad_s[r].vector(), duration_s));
    }
  });
}

bool stay_within(const BallList& balls, const SceneState& state, double duration_s,
                 double falls_m) {
  bool stays = true;
  for (std::size_t i = 0; i < balls.rigid.size(); ++i) {
    const auto r = static_cast<std::size_t>(balls.rigid[i]);
    const Vector4& base = balls.base[i];
    const double left = base.w - falls_m;
    const Vector4 moved = state.rigid_position_m[r] - base;
    // (a + b)^2 <= 2 a^2 + 2 b^2 spares two roots, unless it is near.
    const double way = moved.vector().squaredNorm();
    const double next =
        duration_s * duration_s * state.rigid_velocity_m_s[r].vector().squaredNorm();
    stays = stays && (2.0 * (way + next) < left * left || std::sqrt(way) + std::sqrt(next) < left);
  }
  return stays;
}

}  // namespace stillgrid::dynamics
#endif

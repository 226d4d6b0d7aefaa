#include "shared/dynamics/engine.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "shared/dynamics/at.hpp"
#include "shared/dynamics/coupled_step.hpp"
#include "shared/dynamics/rigid_motion.hpp"
#include "shared/realtime/flush_denormals.hpp"

namespace stillgrid::dynamics {
namespace {

/// Few iterations leave contacts behind their bodies, as if they pulled: light stacks of stiff
/// bodies then fall. RowGroup::iterations() suffice where no contact changes the velocity that it
/// sees by more than that velocity.
int substeps_by_contacts(const ContactRates& rates, double tick_s) {
  constexpr double kMaxRatio = 1.0;
  constexpr int kMaxSubsteps = 64;
  const double spring = rates.stiffness_per_s2 * tick_s * tick_s / kMaxRatio;
  const double damper = rates.damping_per_s * tick_s / kMaxRatio;
  // n^2 - n damper - spring = 0
  const double asked = 0.5 * (damper + std::sqrt(damper * damper + 4.0 * spring));
  return asked > 1.0 ? static_cast<int>(std::ceil(std::min<double>(asked, kMaxSubsteps))) : 1;
}

Description validated(Description description) {
  validate(description);
  return description;
}

}  // namespace

int ticks_of(double step_s) {
  constexpr double kRounding = 1e-9;  // of a step that is a multiple of a tick
  return std::max(1, static_cast<int>(std::ceil(step_s / kTick_s - kRounding)));
}

Engine::Engine(Description description, SceneState state, EngineMethod method)
    : description_(validated(std::move(description))),
      fingerprint_(fingerprint(description_)),
      state_(std::move(state)),
      sleep_(description_),
      springs_(description_),
      listing_(description_),
      fields_(description_),
      forces_N_(description_.nodes.size()),
      poses_of_others_(description_.rigid_bodies.size()),
      wrenches_(description_.joints.empty() ? 0 : description_.rigid_bodies.size()),
      driven_of_rigid_(description_.rigid_bodies.size(), -1),
      meter_(description_),
      spring_bound_(spring_bound(description_)),
      joint_bound_(description_) {
  for (std::size_t r = 0; r < description_.rigid_bodies.size(); ++r) {
    if (!description_.rigid_bodies[r].is_driven) continue;
    driven_of_rigid_[r] = static_cast<std::int32_t>(driven_.size());
    driven_.push_back(r);
  }
  reactions_.resize(driven_.size());
  poses_.resize(driven_.size());
  appeared_.resize(driven_.size());
  held_J_.resize(driven_.size());
  is_tool_.resize(driven_.size());
  for (const std::int32_t s : listing_.tools())
    is_tool_[at(driven_of_rigid_[at(description_.spheres[at(s)].rigid)])] = 1;
  if (state_.proxy_m.empty())
    for (const std::int32_t s : listing_.tools())
      state_.proxy_m.push_back(sphere_position_m(description_.spheres[at(s)], state_));
  state_.proxy_stretch_m.resize(listing_.tools().size());
  if (state_.is_here.empty()) state_.is_here.assign(description_.rigid_bodies.size(), 1);
  const std::size_t movers = description_.nodes.size() + description_.rigid_bodies.size() + 1;
  if (method.make != nullptr) coupled_ = method.make(description_, method.tolerance_m_s);
  bodies_.movers.resize(movers);
  bodies_.changes.resize(movers);
  bodies_.in_turn.resize(movers);
  bodies_.changed.reserve(movers);
  bodies_.inverse_inertias.resize(movers);
  bodies_.places.resize(description_.spheres.size());
  bodies_.arms.resize(description_.spheres.size());
  ways_m_.resize(description_.spheres.size());
  is_listed_.resize(description_.spheres.size() + description_.nodes.size());
  smallest_length_m_ = std::numeric_limits<double>::infinity();
  for (const double length_m : listing_.lengths_m())
    smallest_length_m_ = std::min(smallest_length_m_, length_m);
  const bool has_tool =
      std::ranges::any_of(description_.spheres, [](const auto& sphere) { return sphere.is_tool; });
  const auto is_kinematic = [&](int rigid) {
    const auto& body = description_.rigid_bodies[at(rigid)];
    return body.is_driven && !body.is_fixture;
  };
  for (const Description::Sphere& sphere : description_.spheres)
    if (has_tool && sphere.rigid >= 0 && !sphere.is_tool)
      may_pass_ = may_pass_ && !is_kinematic(sphere.rigid);
  for (const Description::Field& field : description_.fields)
    may_pass_ = may_pass_ && !is_kinematic(field.rigid);
  listing_.set_sleeping(sleep_.spheres(), sleep_.rigid_bodies());
  awake_nodes_.reserve(description_.bodies.size() + 2);
  awake_joints_.reserve(description_.joints.size());
  still_at_.resize(description_.spheres.size());
  still_.arrange(still_at_);  // takes the memory of as many
  touchable_.reserve(listing_.sides_reserved());
  seen_.reserve(touchable_.capacity());
  spaces_.reserve(touchable_.capacity());
  surfaces_.reserve(touchable_.capacity());
  adopt_sleep();
}

Engine::~Engine() = default;

void Engine::set_state(SceneState state) {
  state_ = std::move(state);
  wake_all();
}

void Engine::wake_all() {
  sleep_.wake_all();
  adopt_sleep();
  is_stale_ = true;
}

void Engine::set_gravity(const Eigen::Vector3d& gravity_m_s2) {
  if (gravity_m_s2 == description_.gravity_m_s2) return;
  wake_all();
  description_.gravity_m_s2 = gravity_m_s2;
  fingerprint_ = fingerprint(description_);
}

void Engine::aim_driven(std::span<const DrivenPose> driven, double tick_s) {
  assert(driven.size() == driven_.size());
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    const std::size_t r = driven_[k];
    poses_[k] = driven[k];
    reactions_[k] = {};
    const std::uint8_t is_here = driven[k].is_here ? 1 : 0;
    if (is_here < state_.is_here[r])
      reactions_[k].brought_J = is_tool_[k] != 0
                                    ? -std::exchange(held_J_[k], 0.0)
                                    : -energy_of_contacts_J(listing_, static_cast<int>(r));
    is_stale_ = is_stale_ || is_here != state_.is_here[r];
    appeared_[k] = is_here > state_.is_here[r] ? 1 : 0;
    if (appeared_[k] != 0) {
      state_.rigid_position_m[r] = Vector4(driven[k].position_m - tick_s * driven[k].velocity_m_s);
      state_.orientation[r] = Vector4(driven[k].orientation);
    }
    state_.is_here[r] = is_here;
    const Vector4 way = Vector4(driven[k].position_m) - state_.rigid_position_m[r];
    state_.rigid_velocity_m_s[r] = (is_here != 0 ? 1.0 / tick_s : 0.0) * way;
    const Eigen::Vector3d turn =
        rotation_vector(driven[k].orientation * state_.orientation[r].quaternion().conjugate());
    state_.angular_velocity_rad_s[r] = (is_here != 0 ? 1.0 / tick_s : 0.0) * Vector4(turn);
  }
}

int Engine::substeps_by_stiffness(double tick_s) {
  return stable_substeps(spring_bound_ + joint_bound_(description_, state_, tick_s), tick_s);
}

void Engine::substep(double h) {
  RowList& rows = listing_.rows();
  const auto step = static_cast<float>(h);
  const Vector4 falls = h * Vector4(description_.gravity_m_s2);
  drift(0.5 * h);
  load_movers();
  place_spheres(std::span(other_spheres_).first(listed_others_), h);
  start_balls(balls_, state_, bodies_, h, h * h * description_.gravity_m_s2.norm());
  fields_.place(listing_, state_, bodies_, h);
  prepare_rows(rows, bodies_, step, live_);
  state_.contacts.stiffness_per_s2 =
      std::max(state_.contacts.stiffness_per_s2, live_.rates.stiffness_per_s2);
  state_.contacts.damping_per_s =
      std::max(state_.contacts.damping_per_s, live_.rates.damping_per_s);
  if (counts_losses_) meter_.start(state_, rows, bodies_, live_);
  kick(h, falls);
  kick_balls(balls_, state_, bodies_, falls);
  warm_start_rows(rows, bodies_, live_);
  for (int k = 0; k < kMaxIterations; ++k) solve_rows(rows, bodies_, live_, k);
  finish_rows(rows, step, live_);
  finish_balls(balls_, state_, bodies_, h, falls);
  apply_impulses();
  substep_s_ = h;
  if (counts_losses_) meter_.finish(state_, rows, bodies_, live_, h);
  FieldContacts::finish(listing_);
  if (!driven_.empty()) note_reactions(h);
  drift(0.5 * h);
}

void Engine::list_contacts(double tick_s) {
  listing_.list(state_, tick_s, *live_.sharing);
  adopt_listing();
  place_spheres(other_spheres_, tick_s);
  is_stale_ = false;
}

void Engine::divided_tick(double tick_s, int given_substeps) {
  const int by_speed = given_substeps > 0 ? 1 : substeps_by_speed(tick_s);
  substeps_ = given_substeps > 0 ? given_substeps
                                 : std::max({substeps_by_stiffness(tick_s), by_speed,
                                             substeps_by_contacts(state_.contacts, tick_s)});
  const double substep_s = tick_s / substeps_;
  state_.contacts = {};
  move_proxies(tick_s);
  int moved_at = 0;
  for (int k = 0; k < substeps_; ++k) {
    // A sphere that was struck may be faster than contacts were listed for.
    if (k > 0 && by_speed > 1 && !listing_holds(substep_s)) {
      finish_proxies(static_cast<double>(k - moved_at) / (substeps_ - moved_at));
      moved_at = k;
      list_contacts(tick_s - k * substep_s);
      move_proxies(tick_s - k * substep_s);
    }
    substep(substep_s);
  }
  turn_balls(balls_, state_, tick_s);
  finish_proxies();
}

void Engine::advance(double tick_s, int given_substeps) {
  if (!listing_holds(tick_s)) list_contacts(tick_s);
  wake_touched(tick_s);
  for (std::size_t k = 0; k < driven_.size(); ++k)
    if (appeared_[k] != 0 && is_tool_[k] == 0)
      reactions_[k].brought_J = energy_of_contacts_J(listing_, static_cast<int>(driven_[k]));
  if (coupled_)
    coupled_tick(tick_s);
  else
    divided_tick(tick_s, given_substeps);
}

void Engine::step(std::span<const DrivenPose> driven, double tick_s, int given_substeps) {
  const realtime::FlushDenormals flush;  // or results would depend on the mode of the thread
  aim_driven(driven, tick_s);
  begin_proxies();
  meter_.clear();
  const bool passes_by = passes(tick_s);
  if (passes_by) {
    move_proxies(tick_s);
    finish_proxies();
  } else {
    advance(tick_s, given_substeps);
  }
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    state_.rigid_position_m[driven_[k]] = Vector4(poses_[k].position_m);
    state_.orientation[driven_[k]] = Vector4(poses_[k].orientation);
  }
  ++state_.tick;
  if (sleep_.settle(state_, listing_, bodies_, tick_s)) {
    adopt_sleep();
    list_contacts(tick_s);
    move_proxies(0.0);
  }
}

}  // namespace stillgrid::dynamics

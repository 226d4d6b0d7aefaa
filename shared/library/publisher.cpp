#include "shared/library/publisher.hpp"

#include <algorithm>
#include <cmath>

#include "shared/library/known_part.hpp"
#include "shared/library/numbers.hpp"
#include "shared/library/scene_checks.hpp"
#include "shared/library/tool_figures.hpp"

namespace stillgrid::library {
namespace {

using Header = proto::SegmentHeader;

/// Bodies with an inverse inertia.
constexpr std::size_t kMaxBodies = 4096;
/// Acceleration by a force, of whatever is simulated: a speck of 1e-12 kg.
constexpr double kLightest = 1e12;
/// Ticks in one step at most: the path is as long.
constexpr std::uint64_t kMaxTicks = dynamics::TickPath::kLength - 96;
/// In a snapshot are the bodies that a tool meets at this speed in two periods, and so far besides.
constexpr double kSpeed_m_s = 1.0, kMargin_m = 0.05;
/// A call that waits says after so long that nothing came.
constexpr std::uint64_t kPatience_ns = 100'000'000;

/// What acted on a body beside the tools in the time that led to it, while they pushed it so: an
/// acceleration, and the share of the push that was resisted, by how both changed. Nothing of a
/// body that was not there before.
void explain_motion(std::span<const local::GivenBody> all_before, const local::Twist& push,
                    double step_s, local::GivenBody& body) noexcept {
  constexpr double kChange = 1e-4;  // of the pushes' energy: less tells nothing
  body.push.setZero();
  body.acceleration.setZero();
  body.resisted = 0.0;
  const auto before =
      std::ranges::lower_bound(all_before, body.number, {}, &local::GivenBody::number);
  if (before == all_before.end() || before->number != body.number) return;
  const auto energy = [&](const local::Twist& wrench) {
    return wrench.dot(before->inverse_inertia * wrench);
  };
  body.push = push;
  body.acceleration = (body.twist - before->twist) / step_s - before->inverse_inertia * push;
  const local::Twist change = push - before->push;
  body.resisted = before->resisted;
  if (energy(change) > kChange * (energy(push) + energy(before->push)))
    body.resisted = std::clamp(
        -change.dot(body.acceleration - before->acceleration) / energy(change), 0.0, 1.0);
}

}  // namespace

Publisher::Publisher(const publication::SessionSpec& spec,
                     std::span<const publication::HandScene> hands)
    : spec_(spec),
      period_s_(1e-9 * static_cast<double>(spec.period_ns)),
      session_(spec, publication::SessionLock(spec.name, proto::SegmentKind::kScene), hands),
      moving_(spec.moving_count),
      pushes_(given_model(spec, hands)),
      hands_(hands.size()),
      paths_(hands.size()),
      material_count_(static_cast<std::uint32_t>(hands.front().fixed.materials.size())),
      gives_inertia_(!hands.front().fixed.model.empty()),
      step_s_(period_s_) {
  impulses_.reserve(4 * local::kMaxHeldBodies);
  for (auto* bodies : {&given_, &bodies_, &before_, &shown_, &next_shown_})
    bodies->reserve(std::min(kMaxBodies, std::max<std::size_t>(1, spec.moving_count)));
  if (!is_virtual())
    for (publication::HandSession& session : session_.hands()) session.tool().start();
  if (is_virtual()) peers_.emplace(session_, never_);
}

Publisher::~Publisher() {
  if (!is_virtual()) return;
  session_.promise(&Header::lockstep_sample_ns, proto::kNever);
  session_.promise(&Header::lockstep_event_ns, proto::kNever);
}

bool Publisher::peers_ended() noexcept {
  return std::all_of(session_.hands().begin(), session_.hands().end(), [](auto& hand) {
    const publication::ToolView* view = hand.tool().acquire();
    return view != nullptr &&
           double_buffer::HardwareAtomics::load(view->reader().live().lockstep_sample_ns,
                                                std::memory_order_acquire) == proto::kNever;
  });
}

int Publisher::wait_in_virtual_time(std::uint64_t& time_ns) {
  const std::uint64_t until_ns = realtime::monotonic_ns() + kPatience_ns;
  if (waited_)
    return fail(STILLGRID_E_ORDER, "wait: expected the publication of %llu ns first",
                static_cast<unsigned long long>(time_ns_));
  const bool is_start = session_.hands().front().writer().snapshot_id() == 0;
  if (!is_start) {
    if (!peers_->wait_for_arrival(until_ns)) return STILLGRID_AGAIN;
    const std::uint64_t next_ns = time_ns_ + spec_.period_ns;
    // A sample taken before it is complete when the peer's next one lies after it.
    if (!peers_->wait(&Header::lockstep_sample_ns, next_ns + 1, until_ns)) return STILLGRID_AGAIN;
    if (peers_ended()) return STILLGRID_NOTHING;
    time_ns_ = next_ns;
  }
  waited_ = true;
  time_ns = time_ns_;
  return STILLGRID_OK;
}

int Publisher::wait(std::uint64_t& time_ns) {
  if (is_virtual()) return wait_in_virtual_time(time_ns);
  if (!timer_) {
    timer_.emplace(spec_.period_ns);
    time_ns_ = realtime::monotonic_ns();
  } else {
    time_ns_ = timer_->wait().deadline_ns;
    // Periods that were missed are not made up for: the path of them all is taken as one.
    if (state_ns_)
      stretch_ =
          std::max(1.0, std::round(static_cast<double>(time_ns_ - std::min(time_ns_, *state_ns_)) /
                                   static_cast<double>(spec_.period_ns)));
  }
  waited_ = true;
  time_ns = time_ns_;
  return STILLGRID_OK;
}

int Publisher::set_shapes(const stillgrid_shapes& shapes) {
  if (shapes.count > spec_.moving_count)
    return fail(STILLGRID_E_CAPACITY,
                "shapes.count: %u: expected the %zu of sphere_capacity at most", shapes.count,
                spec_.moving_count);
  if (const int code = check_shapes(shapes, material_count_, false)) return code;
  moving_.declare(shapes);
  is_declared_ = true;
  is_placed_ = false;
  return STILLGRID_OK;
}

int Publisher::set_spheres(std::uint32_t count, const double* positions_m,
                           const double* velocities_m_s) {
  if (!is_declared_ && spec_.moving_count > 0)
    return fail(STILLGRID_E_ORDER, "set_spheres: expected set_shapes() first");
  if (count != moving_.count())
    return fail(STILLGRID_E_ARGUMENT, "set_spheres: %u spheres: expected the %zu of set_shapes()",
                count, moving_.count());
  const std::size_t values = std::size_t{count} * 3;
  if (values > 0 && positions_m == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "positions_m: expected %zu values, not null", values);
  if (const int code = check_numbers({positions_m, values}, "positions_m")) return code;
  if (velocities_m_s != nullptr)
    if (const int code = check_numbers({velocities_m_s, values}, "velocities_m_s")) return code;
  moving_.place(positions_m, velocities_m_s, has_pushes_ ? step_s_ : period_s_, is_shown_);
  is_shown_ = false;
  end_step();
  is_placed_ = true;
  return STILLGRID_OK;
}

/// The step of the last pushes led to the state that is set now.
void Publisher::end_step() noexcept {
  std::swap(bodies_, before_);
  bodies_.clear();
  if (has_pushes_ && state_ns_) {
    add_impulses();
    *state_ns_ += static_cast<std::uint64_t>(std::llround(1e9 * step_s_ * stretch_));
    for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
      hands_[hand].work_J += pushes_.work_J(hand);
      if (const auto newest = paths_[hand].path.newest())
        hands_[hand].told_tool_ns = std::min(*newest * proto::kPathTick_ns, *state_ns_);
    }
  }
  if (!has_pushes_) pushes_.clear();  // else they tell what the step did
  has_pushes_ = false;
}

/// The pushes of the step, in the impulses since the last publication.
void Publisher::add_impulses() noexcept {
  shown_s_ += step_s_;
  for (const auto& [body, wrench] : pushes_.wrenches()) {
    const auto next = std::ranges::lower_bound(impulses_, body, {}, &Impulse::first);
    if (next != impulses_.end() && next->first == body)
      next->second += step_s_ * wrench;
    else if (impulses_.size() < impulses_.capacity())
      impulses_.emplace(next, body, step_s_ * wrench);
  }
}

int Publisher::set_responses(std::span<const stillgrid_response> responses) {
  if (!gives_inertia_)
    return fail(STILLGRID_E_ORDER, "set_responses: expected scene.gives_inertia of 1");
  if (!is_placed_) return fail(STILLGRID_E_ORDER, "set_responses: expected set_spheres() first");
  if (has_pushes_) return fail(STILLGRID_E_ORDER, "set_responses: expected before pushes()");
  if (responses.size() > bodies_.capacity())
    return fail(STILLGRID_E_CAPACITY, "set_responses: %zu: expected %zu at most", responses.size(),
                bodies_.capacity());
  given_.clear();
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const stillgrid_response& response = responses[i];
    const auto are_numbers = [](const auto& values, double largest) {
      return std::all_of(std::begin(values), std::end(values),
                         [&](double x) { return std::abs(x) <= largest; });
    };
    const bool is_sound = are_numbers(response.centre_m, proto::kLargestNumber) &&
                          are_numbers(response.velocity, proto::kLargestNumber) &&
                          are_numbers(response.inverse_inertia, kLightest);
    const auto next =
        std::ranges::lower_bound(given_, response.body, {}, &local::GivenBody::number);
    const bool is_known = next != given_.end() && next->number == response.body;
    const local::Matrix6 inverse_inertia(response.inverse_inertia);
    if (!is_sound || is_known || !local::is_inverse_inertia(inverse_inertia)) {
      return fail(STILLGRID_E_ARGUMENT, "responses[%zu], of body %u: expected %s", i, response.body,
                  !is_sound  ? "numbers"
                  : is_known ? "one of each body"
                             : "a symmetric inverse inertia without an eigenvalue below 0");
    }
    local::GivenBody body{.number = response.body,
                          .centre_m = Eigen::Vector3d(response.centre_m),
                          .twist = local::Twist(response.velocity),
                          .inverse_inertia = 0.5 * (inverse_inertia + inverse_inertia.transpose())};
    explain_motion(before_, pushes_.wrench_of(body.number), step_s_, body);
    given_.insert(next, body);
  }
  std::swap(bodies_, given_);
  return STILLGRID_OK;
}

void Publisher::follow_tools() {
  constexpr std::uint64_t kLedOn = 100;  // ticks, of a tool that is late in real time
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
    const publication::ToolView* tool = session_.hands()[hand].living_tool();
    paths_[hand].led_on_ticks = 0;
    if (tool == nullptr) continue;
    if (std::exchange(hands_[hand].epoch, tool->header().epoch) != tool->header().epoch)
      paths_[hand].path.clear();
    dynamics::follow(tool->path(), paths_[hand].path);
    const std::uint64_t between = tool->header().period_ns / proto::kPathTick_ns;
    paths_[hand].led_on_ticks = is_virtual() ? std::min(between, kLedOn) : kLedOn;
  }
}

int Publisher::find_pushes(double step_s, std::span<stillgrid_push> pushes, std::uint32_t& count) {
  if (!is_placed_) return fail(STILLGRID_E_ORDER, "pushes: expected set_spheres() first");
  if (!(step_s > 0.0 && step_s <= 10.0))
    return fail(STILLGRID_E_ARGUMENT, "pushes: step of %g s: expected more than 0, 10 at most",
                step_s);
  follow_tools();
  pushes_.clear();
  if (state_ns_) {
    const std::uint64_t end_ns = *state_ns_ + static_cast<std::uint64_t>(1e9 * step_s * stretch_);
    const std::uint64_t to = end_ns / proto::kPathTick_ns;
    const std::uint64_t from = std::min(*state_ns_ / proto::kPathTick_ns, to - 1);
    pushes_.find(moving_, bodies_, paths_, std::max(from, to - std::min(to, kMaxTicks)), to);
  }
  const std::span<const stillgrid_push> found = pushes_.pushes();
  count = static_cast<std::uint32_t>(found.size());
  if (found.size() > pushes.size()) {
    pushes_.clear();  // nobody was told
    return fail(STILLGRID_E_CAPACITY, "pushes: room for %zu: expected for %zu", pushes.size(),
                found.size());
  }
  std::ranges::copy(found, pushes.begin());
  step_s_ = step_s;
  has_pushes_ = true;
  return STILLGRID_OK;
}

publication::SnapshotState Publisher::state_at(std::uint64_t state_ns) {
  if (!gives_inertia_) return {};
  follow_tools();
  const std::uint64_t tick = state_ns / proto::kPathTick_ns;
  const double step_s = shown_s_ > 0.0 ? shown_s_ : period_s_;
  next_shown_.assign(bodies_.begin(), bodies_.end());
  for (local::GivenBody& body : next_shown_) {
    const auto found = std::ranges::lower_bound(impulses_, body.number, {}, &Impulse::first);
    local::Twist push = local::Twist::Zero();
    if (found != impulses_.end() && found->first == body.number) push = found->second / step_s;
    explain_motion(shown_, push, step_s, body);
  }
  std::swap(shown_, next_shown_);
  impulses_.clear();
  shown_s_ = 0.0;
  return {.bytes = pushes_.state_at(tick, moving_, shown_, paths_,
                                    kMargin_m + 2.0 * period_s_ * kSpeed_m_s),
          .tick = tick};
}

int Publisher::publish(std::uint64_t state_time_ns) {
  if (!is_placed_ && spec_.moving_count > 0)
    return fail(STILLGRID_E_ORDER, "publish: expected set_spheres() first");
  if (is_virtual() && !waited_)
    return fail(STILLGRID_E_ORDER, "publish: expected wait() first, in virtual time");
  if (is_virtual() && state_time_ns != 0 && state_time_ns != time_ns_)
    return fail(STILLGRID_E_ARGUMENT, "publish: state of %llu ns: expected %llu, as wait() gave it",
                static_cast<unsigned long long>(state_time_ns),
                static_cast<unsigned long long>(time_ns_));
  const std::uint64_t began_ns = realtime::monotonic_ns();
  if (!is_virtual() && state_time_ns > began_ns + 10'000'000'000)
    return fail(
        STILLGRID_E_ARGUMENT, "publish: state of %llu ns: expected CLOCK_MONOTONIC's, now %llu",
        static_cast<unsigned long long>(state_time_ns), static_cast<unsigned long long>(began_ns));
  const std::uint64_t state_ns = state_time_ns != 0 ? state_time_ns : waited_ ? time_ns_ : began_ns;
  if (!is_virtual() && state_ns < published_ns_)
    return fail(
        STILLGRID_E_ARGUMENT, "publish: state of %llu ns: expected none before the last, %llu",
        static_cast<unsigned long long>(state_ns), static_cast<unsigned long long>(published_ns_));
  published_ns_ = state_ns;
  if (is_virtual() && state_ns > 0) {
    session_.promise(&Header::lockstep_sample_ns, state_ns + spec_.period_ns);
    if (!peers_->wait(&Header::lockstep_event_ns, state_ns)) return STILLGRID_NOTHING;
  }
  state_ns_ = state_ns;
  stretch_ = 1.0;
  is_shown_ = true;
  const publication::SnapshotState state = state_at(state_ns);
  for (std::size_t hand = 0; hand < hands_.size(); ++hand) {
    publication::SceneWriter& writer = session_.hands()[hand].writer();
    writer.segment().require_whole();
    const std::uint64_t now_ns = realtime::monotonic_ns();
    writer.publish(moving_.grid(),
                   {.state_ns = state_ns,
                    .publish_ns = is_virtual() ? state_ns : now_ns,
                    .tool_ns = hands_[hand].told_tool_ns,
                    .step_ns = is_virtual() || !waited_ ? 0 : now_ns - std::min(now_ns, time_ns_),
                    .contacts = 0,
                    .tool_work_J = hands_[hand].work_J},
                   {}, state);
  }
  if (is_virtual()) {
    session_.promise(&Header::lockstep_sample_ns, state_ns + spec_.period_ns);
    session_.promise(&Header::lockstep_event_ns, state_ns + spec_.period_ns);
  }
  waited_ = false;
  return STILLGRID_OK;
}

int Publisher::take_tool(std::uint32_t hand, stillgrid_tool& tool) {
  if (hand >= hands_.size())
    return fail(STILLGRID_E_ARGUMENT, "hand: %u: expected 0 to %zu", hand, hands_.size() - 1);
  const auto state = session_.hands()[hand].take_tool();
  if (!state) return STILLGRID_NOTHING;
  const stillgrid_tool figures = tool_figures(*state);
  give_known(figures, &tool);
  return STILLGRID_OK;
}

}  // namespace stillgrid::library

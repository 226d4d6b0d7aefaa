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

/// Bodies that may give way in a step.
constexpr std::size_t kMaxBodies = 4096;
/// Acceleration by a force, of whatever is simulated: a speck of 1e-12 kg.
constexpr double kLightest = 1e12;
/// A call that waits says after so long that nothing came.
constexpr std::uint64_t kPatience_ns = 100'000'000;

}  // namespace

Publisher::Publisher(const publication::SessionSpec& spec,
                     std::span<const publication::HandScene> hands)
    : spec_(spec),
      period_s_(1e-9 * static_cast<double>(spec.period_ns)),
      session_(spec, publication::SessionLock(spec.name, proto::SegmentKind::kScene), hands),
      moving_(spec.moving_count),
      material_count_(static_cast<std::uint32_t>(hands.front().fixed.materials.size())),
      predicts_(hands.front().fixed.predicts) {
  bodies_.reserve(std::min(kMaxBodies, std::max<std::size_t>(1, spec.moving_count)));
  given_.reserve(bodies_.capacity());
  trial_.reserve(3 * spec.moving_count);
  predicted_.reserve(3 * spec.moving_count);
  for (publication::HandSession& session : session_.hands()) {
    hands_.push_back(std::make_unique<Hand>(session, spec.moving_count));
    if (!is_virtual()) session.tool().start();
  }
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
  moving_.place(positions_m, velocities_m_s, period_s_);
  for (const auto& hand : hands_) {
    if (has_pushes_) {
      hand->work_J += hand->pushes.work_J(moving_);
      hand->told_tool_ns = hand->tool_ns;
    }
    hand->pushes.end_step();
  }
  bodies_.clear();
  trial_.clear();
  predicted_.clear();
  has_pushes_ = false;
  is_placed_ = true;
  return STILLGRID_OK;
}

int Publisher::set_responses(std::span<const stillgrid_response> responses) {
  if (!predicts_) return fail(STILLGRID_E_ORDER, "set_responses: expected scene.predicts of 1");
  if (!is_placed_) return fail(STILLGRID_E_ORDER, "set_responses: expected set_spheres() first");
  if (has_pushes_) return fail(STILLGRID_E_ORDER, "set_responses: expected before pushes()");
  if (responses.size() > bodies_.capacity())
    return fail(STILLGRID_E_CAPACITY, "set_responses: %zu: expected %zu at most", responses.size(),
                bodies_.capacity());
  given_.clear();
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const stillgrid_response& response = responses[i];
    const bool are_numbers =
        std::all_of(std::begin(response.centre_m), std::end(response.centre_m), is_number) &&
        std::all_of(std::begin(response.inverse_inertia), std::end(response.inverse_inertia),
                    [](double x) { return std::abs(x) <= kLightest; });
    const auto body = std::lower_bound(
        given_.begin(), given_.end(), response.body,
        [](const BodyModes& a, std::uint32_t wanted) { return a.body() < wanted; });
    const bool is_known = body != given_.end() && body->body() == response.body;
    BodyModes modes;
    if (!are_numbers || is_known || !modes.take(response)) {
      return fail(STILLGRID_E_ARGUMENT, "responses[%zu], of body %u: expected %s", i, response.body,
                  !are_numbers ? "numbers"
                  : is_known   ? "one of each body"
                               : "a symmetric inverse inertia without an eigenvalue below 0");
    }
    given_.insert(body, modes);
  }
  std::swap(bodies_, given_);
  return STILLGRID_OK;
}

void Publisher::push_with_all_hands(double step_s) {
  for (BodyModes& body : bodies_) body.set_step(step_s);
  for (const auto& hand : hands_) {
    moving_.forget_predictions();
    if (!trial_.empty()) {
      moving_.predict(trial_);
      moving_.cover_predictions(step_s);
    }
    const auto tool = hand->session.take_tool();
    hand->tool_ns = tool ? tool->time_ns : 0;
    if (tool)
      hand->pushes.find(hand->session.writer().scene(), *tool, moving_, bodies_, step_s,
                        !trial_.empty());
    else
      hand->pushes.clear();
  }
  has_pushes_ = true;
}

int Publisher::find_pushes(double step_s, std::span<stillgrid_push> pushes, std::uint32_t& count) {
  if (!is_placed_) return fail(STILLGRID_E_ORDER, "pushes: expected set_spheres() first");
  if (!(step_s > 0.0 && step_s <= 10.0))
    return fail(STILLGRID_E_ARGUMENT, "pushes: step of %g s: expected more than 0, 10 at most",
                step_s);
  push_with_all_hands(step_s);
  std::size_t all = 0;
  for (const auto& hand : hands_)
    for (const stillgrid_push& push : hand->pushes.pushes()) {
      if (all < pushes.size()) pushes[all] = push;
      ++all;
    }
  count = static_cast<std::uint32_t>(all);
  if (all > pushes.size()) {
    has_pushes_ = false;  // nobody was told
    return fail(STILLGRID_E_CAPACITY, "pushes: room for %zu: expected for %zu", pushes.size(), all);
  }
  return STILLGRID_OK;
}

int Publisher::take_velocities(const char* name, std::uint32_t count, const double* velocities_m_s,
                               std::vector<double>& velocities) const {
  if (!predicts_) return fail(STILLGRID_E_ORDER, "%s: expected scene.predicts of 1", name);
  if (!is_placed_) return fail(STILLGRID_E_ORDER, "%s: expected set_spheres() first", name);
  if (count != moving_.count())
    return fail(STILLGRID_E_ARGUMENT, "%s: %u spheres: expected the %zu of set_shapes()", name,
                count, moving_.count());
  const std::span<const double> values(velocities_m_s, std::size_t{count} * 3);
  if (const int code = check_numbers(values, "velocities_m_s")) return code;
  velocities.assign(values.begin(), values.end());
  return STILLGRID_OK;
}

int Publisher::set_trial(std::uint32_t count, const double* velocities_m_s) {
  if (has_pushes_) return fail(STILLGRID_E_ORDER, "set_trial: expected before pushes()");
  return take_velocities("set_trial", count, velocities_m_s, trial_);
}

int Publisher::set_predicted(std::uint32_t count, const double* velocities_m_s) {
  return take_velocities("set_predicted", count, velocities_m_s, predicted_);
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
  if (!has_pushes_ && !bodies_.empty()) push_with_all_hands(period_s_);
  if (is_virtual() && state_ns > 0) {
    session_.promise(&Header::lockstep_sample_ns, state_ns + spec_.period_ns);
    if (!peers_->wait(&Header::lockstep_event_ns, state_ns)) return STILLGRID_NOTHING;
  }
  for (const auto& hand : hands_) {
    publication::SceneWriter& writer = hand->session.writer();
    writer.segment().require_whole();
    publication::SnapshotPrediction prediction;
    if (predicts_) {
      moving_.forget_predictions();
      if (!trial_.empty()) moving_.predict(trial_);
      prediction = hand->pushes.predict(moving_, period_s_, predicted_);
      moving_.cover_predictions(period_s_);
    }
    const std::uint64_t now_ns = realtime::monotonic_ns();
    writer.publish(moving_.grid(),
                   {.state_ns = state_ns,
                    .publish_ns = is_virtual() ? state_ns : now_ns,
                    .tool_ns = hand->told_tool_ns,
                    .step_ns = is_virtual() || !waited_ ? 0 : now_ns - std::min(now_ns, time_ns_),
                    .contacts = 0,
                    .tool_work_J = hand->work_J},
                   prediction);
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
  const auto state = hands_[hand]->session.take_tool();
  if (!state) return STILLGRID_NOTHING;
  const stillgrid_tool figures = tool_figures(*state);
  give_known(figures, &tool);
  return STILLGRID_OK;
}

}  // namespace stillgrid::library

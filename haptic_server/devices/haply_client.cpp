#include "haptic_server/devices/haply_client.hpp"

#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <utility>

namespace stillgrid::devices {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kMillisecond_ns = 1'000'000;
constexpr std::uint64_t kForceHolds_ns = 50 * kMillisecond_ns;  // then the loop hangs
constexpr std::uint64_t kLate_ns = 5 * kMillisecond_ns;         // of a round trip
constexpr std::uint64_t kLateFor_ns = 200 * kMillisecond_ns;
constexpr int kRamp = 100;  // replies
constexpr milliseconds kRelease{200};
constexpr int kPriority = 70;  // below the haptic loop's 80

/// While it lives this thread and those it starts take no signals: they are the program's.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

void sleep_until(std::uint64_t time_ns) {
  const timespec time{static_cast<std::time_t>(time_ns / 1'000'000'000),
                      static_cast<long>(time_ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

std::string text_of(const Eigen::Vector3d& force_N) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%.2f %.2f %.2f N", force_N.x(), force_N.y(),
                force_N.z());
  return text.data();
}

}  // namespace

std::uint64_t monotonic_ns() noexcept {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(now).count());
}

HaplyClient::HaplyClient(std::unique_ptr<HaplyConnection> connection, HaplyChoice choice,
                         HaplyStop& stop, const HostLog& log)
    : connection_(std::move(connection)), choice_(std::move(choice)), stop_(stop), log_(log) {
  timely_ns_ = monotonic_ns();
  exchange(Eigen::Vector3d::Zero());
}

void HaplyClient::start() {
  const SignalsHeld held;
  thread_ = std::jthread([this](const std::stop_token& end) { run(end); });
  pthread_setname_np(thread_.native_handle(), "haply");
  if (!choice_.tick) {  // without the right to it the thread is an ordinary one
    const sched_param priority{kPriority};
    (void)pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  }
}

HaplyClient::~HaplyClient() {
  release();
}

bool HaplyClient::release() noexcept {
  thread_ = {};
  return is_released_;
}

void HaplyClient::run(const std::stop_token& end) noexcept {
  try {
    converse(end);
  } catch (const std::exception& fault) {
    end_in_fault(end, fault.what());
  }
  connection_.reset();
}

void HaplyClient::converse(const std::stop_token& end) {
  is_ticked_ = static_cast<bool>(choice_.tick);
  std::uint64_t next_ns = monotonic_ns();
  while (!end.stop_requested()) {
    next_ns += choice_.period_ns;
    if (const std::uint64_t now_ns = monotonic_ns(); now_ns < next_ns)
      sleep_until(next_ns);
    else
      next_ns = now_ns;  // the service is slower than the period: its answers are the pace
    // A state that waited a period would make the force a period late: it is asked for again,
    // where there is time for that.
    if (is_ticked_ && 3 * round_trip_ns_ < choice_.period_ns) exchange(force_now());
    if (is_ticked_) is_ticked_ = choice_.tick();
    exchange(force_now());
  }
  const std::uint64_t until_ns =
      monotonic_ns() + static_cast<std::uint64_t>(std::chrono::nanoseconds(kRelease).count());
  while (!is_released_ && monotonic_ns() < until_ns) {
    exchange(Eigen::Vector3d::Zero());
    is_released_ = heard_N_.norm() <= HaplyEcho::kTolerance_N;
  }
}

void HaplyClient::end_in_fault(const std::stop_token& end, const std::string& line) noexcept {
  try {
    fault_ = line;
  } catch (const std::bad_alloc&) {  // a fault without its line is one too
  }
  has_failed_.store(true, std::memory_order_release);
  stop_.send_zero();
  connection_.reset();
  // The host learns of the fault in a tick.
  while (is_ticked_ && !end.stop_requested()) {
    is_ticked_ = choice_.tick();
    sleep_until(monotonic_ns() + choice_.period_ns);
  }
}

Eigen::Vector3d HaplyClient::force_now() noexcept {
  const Command& command = commands_.take();
  const bool is_held = monotonic_ns() > command.time_ns + kForceHolds_ns;
  const bool has_teller = is_ticked_ || !choice_.tick;
  if (is_held || stop_.is_stopped() || !has_teller) return Eigen::Vector3d::Zero();
  const double share = 1.0 - static_cast<double>(ramp_) / kRamp;
  return share * Eigen::Map<const Eigen::Vector3d>(command.force_N.data());
}

void HaplyClient::send(const Eigen::Vector3d& force_N) {
  write_haply_force(text_, choice_.arm, choice_.spelling, force_N);
  connection_->send(text_);
}

void HaplyClient::exchange(const Eigen::Vector3d& force_N) {
  connection_->discard();
  const std::uint64_t sent_ns = monotonic_ns();
  echo_.sent(force_N);
  send(force_N);
  const HaplyMessage message = read_haply_message(connection_->receive(kSilence));
  const std::uint64_t now_ns = monotonic_ns();
  const std::uint64_t trip_ns = now_ns - sent_ns;
  round_trip_ns_ = (7 * round_trip_ns_ + trip_ns) / 8;
  if (trip_ns <= kLate_ns) timely_ns_ = now_ns;
  if (now_ns - timely_ns_ > kLateFor_ns)
    throw HaplyConnectionError("the service is slow: for 200 ms no answer came within 5 ms");
  take(message, now_ns);
}

void HaplyClient::take(const HaplyMessage& message, std::uint64_t now_ns) {
  const HaplyArm* const arm = message.arm(choice_.arm);
  if (arm == nullptr)
    throw HaplyProtocolError("device " + choice_.arm + " has left the service: was it unplugged?");
  if (!arm->foreign_frame.empty())
    throw HaplyProtocolError("the service moves the frame by " + arm->foreign_frame +
                             ": expected the device's own, without a profile");
  if (!arm->force_N)
    throw HaplyProtocolError(
        "the service tells no current_cursor_force, which a force is compared with: expected "
        "version 3.1 or newer");
  judge(*arm->force_N);
  if (ramp_ > 0) --ramp_;
  newest_.time_ns = now_ns;
  ++newest_.sequence;
  Eigen::Map<Eigen::Vector3d>(newest_.position_m.data()) = arm->position_m;
  Eigen::Map<Eigen::Vector3d>(newest_.velocity_m_s.data()) = arm->velocity_m_s;
  newest_.status = arm->status;
  newest_.status_known = arm->status_known;
  const HaplyGrip* const grip = message.grip(choice_.grip);
  if (grip == nullptr && !choice_.grip.empty() && !std::exchange(misses_grip_, true))
    log_.warn("grip " + choice_.grip + " has left the service: no orientation, no buttons");
  newest_.has_orientation = grip != nullptr && grip->orientation.has_value();
  if (newest_.has_orientation)
    Eigen::Map<Eigen::Vector4d>(newest_.orientation_xyzw.data()) = grip->orientation->coeffs();
  newest_.buttons = grip != nullptr ? grip->buttons : 0;
  samples_.put(newest_);
}

void HaplyClient::judge(const Eigen::Vector3d& heard_N) {
  heard_N_ = heard_N;
  const HaplyEcho::Verdict verdict = echo_.heard(heard_N);
  if (verdict == HaplyEcho::Verdict::kAgrees) return;
  const bool is_ignored = verdict == HaplyEcho::Verdict::kIgnored;
  if (is_ignored && std::exchange(has_other_spelling_, false)) {
    // Safe, for no force has ever been applied, and this one comes in from zero.
    const bool is_vector = choice_.spelling == HaplySpelling::kVector;
    choice_.spelling = is_vector ? HaplySpelling::kValues : HaplySpelling::kVector;
    ramp_ = kRamp;
    echo_.reset();
    log_.warn(std::string("the service ignores a force named '") +
              (is_vector ? "vector': 'values'" : "values': 'vector'") + " is tried");
    return;
  }
  throw HaplyProtocolError(
      is_ignored ? "the service applies no force, be it named 'vector' or 'values': expected "
                   "version 3.1 to 3.5"
                 : "the service applies " + text_of(heard_N) + " where " +
                       text_of(echo_.last_sent_N()) + " was sent: expected nobody else's force");
}

}  // namespace stillgrid::devices

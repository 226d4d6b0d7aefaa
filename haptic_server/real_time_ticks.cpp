#include "haptic_server/real_time_ticks.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "haptic_server/device_life.hpp"
#include "shared/realtime/realtime_guard.hpp"
#include "shared/realtime/realtime_thread.hpp"
#include "shared/realtime/rights/realtime_rights.hpp"

namespace stillgrid::haptic_server {
namespace {

constexpr auto kPoll = std::chrono::milliseconds(5);

/// The second half of what take_rights() began for a thread, which may be another than this one.
void complete_rights(realtime::RealtimeRights& rights, pid_t thread) {
  realtime::ask_realtime_kit(rights, thread);
  if (const std::string missing = realtime::missing_line(rights); !missing.empty())
    spdlog::warn("running without {}", missing);
}

bool must_recover(const Run& run) {
  return !run.watchdog.is_stopping() && run.watchdog.stops() != run.report.device_stops;
}

using Wake = realtime::PeriodicTimer::Wake;

/// Begins with a tick for a wake that has had none. Returns such a wake where the device was
/// stopped and is to go on, which may block; nothing at the end.
std::optional<Wake> tick_until_stopped(Run& run, RealTimeTicks& ticks,
                                       realtime::PeriodicTimer& timer, std::optional<Wake> wake) {
  const long faults_before = realtime::page_faults();
  {
    realtime::RealtimeSection section;
    for (bool goes_on = true; goes_on; wake.reset()) {
      section.begin_tick(run.report.ticks + 1);
      if (!wake) {
        wake = timer.wait();
        if (must_recover(run)) break;
      }
      goes_on = ticks.tick(*wake);
    }
  }
  run.report.page_faults += realtime::page_faults() - faults_before;
  return wake;
}

/// The loop's own thread, a period after the other.
void tick_at_own_pace(Run& run, RealTimeTicks& ticks) {
  realtime::PeriodicTimer timer(run.period_ns);
  std::optional<Wake> wake;
  while ((wake = tick_until_stopped(run, ticks, timer, wake))) ticks.recover();
}

/// Says that a device ticks at another rate than it was told to, once while it does.
class PaceCheck {
 public:
  PaceCheck(const Run& run, const RealTimeTicks& ticks) : run_(run), ticks_(ticks) {}

  void look() {
    const std::uint64_t now_ns = realtime::monotonic_ns(), ticked = ticks_.device_ticks();
    if (now_ns - from_ns_ < 1'000'000'000) return;
    const double rate_hz =
        1e9 * static_cast<double>(ticked - from_ticks_) / static_cast<double>(now_ns - from_ns_);
    const double asked_hz = 1e9 / static_cast<double>(run_.period_ns);
    seconds_off_ = std::abs(rate_hz - asked_hz) > kTolerance * asked_hz ? seconds_off_ + 1 : 0;
    if (seconds_off_ == kPatience_s) {
      spdlog::warn("device '{}' ticks at {:.0f} Hz; expected {:.0f} Hz", run_.report.device,
                   rate_hz, asked_hz);
    }
    from_ns_ = now_ns;
    from_ticks_ = ticked;
  }

 private:
  static constexpr double kTolerance = 0.2;
  static constexpr int kPatience_s = 2;  // a fault makes itself known sooner
  const Run& run_;
  const RealTimeTicks& ticks_;
  std::uint64_t from_ns_ = realtime::monotonic_ns(), from_ticks_ = ticks_.device_ticks();
  int seconds_off_ = 0;
};

/// The device's thread ticks; this one only sees to it that a device that was stopped goes on.
void wait_for_device_pace(Run& run, RealTimeTicks& ticks) {
  PaceCheck pace(run, ticks);
  while (!ticks.is_over()) {
    std::this_thread::sleep_for(kPoll);
    if (must_recover(run)) ticks.recover();
    ticks.complete_rights_of_device();
    pace.look();
  }
}

}  // namespace

bool RealTimeTicks::tick(const realtime::PeriodicTimer::Wake& wake) {
  if (end_ns_ == 0)
    end_ns_ = run_.options.duration_s ? wake.now_ns + realtime::to_ns(*run_.options.duration_s)
                                      : proto::kNever;
  bool is_over = (run_.stop || wake.now_ns >= end_ns_) && run_.loop.release();
  if (!is_over && !run_.watchdog.is_stopping()) {
    run_.watchdog.tick();
    run_.tool.segment().require_whole();
    const HandView& scene = *run_.watch.acquire(run_.loop.may_switch_scene());
    end_ = run_.loop.sense(scene, wake.now_ns);
    if (end_ == TickEnd::kGoOn) {
      end_ = run_.loop.act(scene, run_.watch.writer_alive(), wake.now_ns, row_,
                           scene.look_at_tools(), scene.local());
      row_.tick_ns = realtime::monotonic_ns() - wake.now_ns;
      run_.report.missed_ticks += wake.skipped > 0 ? 1 : 0;
      run_.report.wake_ns.record(wake.now_ns - wake.deadline_ns);
      run_.loop.note_times(row_.tick_ns, wake.now_ns - wake.deadline_ns, run_.report.missed_ticks);
      run_.loop.count(row_, run_.report);
      run_.driver.note(row_.flags);
      if (run_.recorder != nullptr) run_.recorder->record(row_);
    }
    is_over = end_ != TickEnd::kGoOn;
  }
  if (is_over) is_over_.store(true, std::memory_order_release);
  return !is_over;
}

void RealTimeTicks::enter_thread() {
  thread_ = std::this_thread::get_id();
  is_second_ = false;
  const std::scoped_lock lock(rights_mutex_);
  run_.report.rights = realtime::take_rights(run_.options.cpu);
  needs_rights_ = ::gettid();
}

void RealTimeTicks::complete_rights_of_device() {
  std::unique_lock lock(rights_mutex_);
  const pid_t thread = std::exchange(needs_rights_, 0);
  if (thread == 0) return;
  realtime::RealtimeRights rights = run_.report.rights;
  lock.unlock();  // a new thread of the device's enters in a tick
  complete_rights(rights, thread);
  lock.lock();
  if (needs_rights_ == 0) run_.report.rights = rights;
}

bool RealTimeTicks::tick_at_device_pace() {
  if (thread_ != std::this_thread::get_id()) {
    enter_thread();
  } else if (!std::exchange(is_second_, true)) {
    // What the driver's loop touches first, between its ticks, is none of theirs.
    faults_before_ = realtime::page_faults();
  }
  const std::uint64_t now_ns = realtime::monotonic_ns();
  const std::uint64_t deadline_ns = next_ns_ == 0 ? now_ns : std::min(next_ns_, now_ns);
  next_ns_ = now_ns + run_.period_ns;
  realtime::RealtimeSection section;
  section.begin_tick(run_.report.ticks + 1);
  return tick({deadline_ns, now_ns, (now_ns - deadline_ns) / run_.period_ns});
}

std::int32_t RealTimeTicks::on_device_tick(void* ticks) noexcept {
  RealTimeTicks& self = *static_cast<RealTimeTicks*>(ticks);
  if (self.is_ticking_.exchange(true, std::memory_order_seq_cst)) {
    self.ticked_twice_.store(true, std::memory_order_relaxed);
    self.is_over_.store(true, std::memory_order_release);
    return 1;
  }
  self.device_ticks_.fetch_add(1, std::memory_order_relaxed);
  const bool goes_on = !self.is_over_.load(std::memory_order_seq_cst) && self.goes_on();
  self.is_ticking_.store(false, std::memory_order_release);
  return goes_on ? 0 : 1;
}

bool RealTimeTicks::goes_on() noexcept {
  // Until the other thread has activated the device anew.
  if (run_.watchdog.is_stopping() || run_.watchdog.stops() != stops_.load()) return true;
  try {
    if (tick_at_device_pace()) return true;
    run_.report.page_faults += realtime::page_faults() - faults_before_;
  } catch (...) {
    thrown_ = std::current_exception();
    is_over_.store(true, std::memory_order_release);
  }
  return false;
}

void RealTimeTicks::recover() {
  count_stop(run_);
  deactivate(run_);
  run_.loop.cut();
  resume();
  activate(run_);
  run_.watchdog.watch_ticks();
}

void RealTimeTicks::resume() noexcept {
  end_ = TickEnd::kGoOn;
  next_ns_ = 0;
  stops_.store(run_.watchdog.stops());
  is_over_.store(false, std::memory_order_release);
}

void RealTimeTicks::end() noexcept {
  is_over_.store(true, std::memory_order_seq_cst);
  while (is_ticking_.load(std::memory_order_seq_cst))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TickEnd RealTimeTicks::outcome() const {
  if (ticked_twice_)
    throw DeviceFault("device '" + run_.report.device +
                      "': two threads ticked at once; expected one that sets the pace");
  if (thrown_) std::rethrow_exception(thrown_);
  return end_;
}

void run_real_time(Run& run) {
  // Never destroyed: a driver's thread may still call it. Static, so that no leak is reported.
  static RealTimeTicks* latest = nullptr;
  latest = new RealTimeTicks(run);
  RealTimeTicks& ticks = *latest;
  const bool is_devices_pace = run.device.sets_pace();
  run.watch.start();
  if (is_devices_pace) run.device.set_tick(RealTimeTicks::on_device_tick, &ticks);
  try {
    if (!is_devices_pace) {
      run.report.rights = realtime::take_rights(run.options.cpu);
      complete_rights(run.report.rights, ::gettid());
    }
    activate(run);
    for (;;) {
      run.watchdog.watch_ticks();
      if (is_devices_pace)
        wait_for_device_pace(run, ticks);
      else
        tick_at_own_pace(run, ticks);
      if (ticks.outcome() != TickEnd::kDeviceFault) return;
      if (run.options.reopenings == 0) throw_fault(run);
      if (!reopen(run, ticks)) return;
    }
  } catch (...) {
    ticks.end();
    throw;
  }
}

}  // namespace stillgrid::haptic_server

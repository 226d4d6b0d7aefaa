#include "shared/tools/scene_viewer/tick_history.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "shared/tools/scene_viewer/binary_message.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr double kKept_s = 60.0;
constexpr std::size_t kMaxTicks = 120'000;  // whatever the rate

/// Sorts the values.
TickPercentiles percentiles_of(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    return values.empty() ? 0.0 : values[std::max<std::size_t>(rank, 1) - 1];
  };
  return {at(0.5), at(0.99), at(0.999)};
}

}  // namespace

TickSummary summary_of(std::span<const TickSample> samples) {
  TickSummary summary;
  if (samples.empty()) return summary;
  const TickSample& last = samples.back();
  std::vector<double> work_us, wake_us;
  const TickSample* first = &last;
  for (auto sample = samples.rbegin(); sample != samples.rend(); ++sample) {
    const double before_s = last.time_s - sample->time_s;
    if (!(before_s >= 0.0 && before_s < 1.0)) break;  // virtual time may begin again
    first = &*sample;
    work_us.push_back(sample->work_us);
    wake_us.push_back(sample->wake_us);
  }
  summary.seen = work_us.size();
  summary.expected = last.tick - first->tick + 1;
  const double span_s = last.time_s - first->time_s;
  if (span_s > 0.0) summary.per_s = static_cast<double>(last.tick - first->tick) / span_s;
  summary.missed = last.missed;
  summary.work_us = percentiles_of(work_us);
  summary.wake_us = percentiles_of(wake_us);
  return summary;
}

std::string tick_message(std::span<const TickSample> samples) {
  std::vector<double> tick, time_s, snapshot_id;
  std::vector<float> position_m, force_N, age_s, work_us, wake_us;
  std::vector<std::uint32_t> flags, contacts;
  for (const TickSample& sample : samples) {
    tick.push_back(static_cast<double>(sample.tick));
    time_s.push_back(sample.time_s);
    for (const double x : sample.position_m) position_m.push_back(static_cast<float>(x));
    for (const double f : sample.force_N) force_N.push_back(static_cast<float>(f));
    age_s.push_back(static_cast<float>(sample.age_s));
    work_us.push_back(static_cast<float>(sample.work_us));
    wake_us.push_back(static_cast<float>(sample.wake_us));
    flags.push_back(sample.flags);
    contacts.push_back(sample.contacts);
    snapshot_id.push_back(static_cast<double>(sample.snapshot_id));
  }
  return binary_message({array_of("tick", tick), array_of("time_s", time_s),
                         array_of("position_m", position_m), array_of("force_N", force_N),
                         array_of("age_s", age_s), array_of("tick_us", work_us),
                         array_of("wake_us", wake_us), array_of("flags", flags),
                         array_of("snapshot_id", snapshot_id), array_of("contacts", contacts)});
}

std::span<const TickSample> ticks_from(std::span<const TickSample> samples, std::uint64_t from,
                                       std::size_t most) {
  const auto begin = std::lower_bound(
      samples.begin(), samples.end(), from,
      [](const TickSample& sample, std::uint64_t tick) { return sample.tick < tick; });
  const auto left = samples.subspan(static_cast<std::size_t>(begin - samples.begin()));
  return left.first(std::min(most, left.size()));
}

void TickHistory::add(const TickSample& sample) {
  const std::lock_guard lock(mutex_);
  samples_.push_back(sample);
  if (samples_.size() < 2 * kMaxTicks && !(sample.time_s - samples_.front().time_s > 2.0 * kKept_s))
    return;
  const auto is_old = [&](const TickSample& old) { return sample.time_s - old.time_s > kKept_s; };
  const auto kept = std::find_if_not(samples_.begin(), samples_.end(), is_old);
  const auto most = static_cast<std::ptrdiff_t>(kMaxTicks);
  samples_.erase(
      samples_.begin(),
      std::max(kept, samples_.end() - std::min(samples_.end() - samples_.begin(), most)));
}

std::vector<TickSample> TickHistory::from(std::uint64_t from, std::size_t most) const {
  const std::lock_guard lock(mutex_);
  const auto found = ticks_from(samples_, from, most);
  return {found.begin(), found.end()};
}

TickSummary TickHistory::summary() const {
  const std::lock_guard lock(mutex_);
  return summary_of(samples_);
}

}  // namespace stillgrid::scene_viewer

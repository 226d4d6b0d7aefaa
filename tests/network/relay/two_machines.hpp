#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "shared/tools/scene_relay/other_side.hpp"

namespace stillgrid::scene_relay {

/// A clock that drifts and stands still while its machine sleeps. Times in ns.
class MachineClock {
 public:
  MachineClock(std::uint64_t start_ns, double drift) : start_ns_(start_ns), drift_(drift) {}

  [[nodiscard]] std::uint64_t at(std::uint64_t true_ns) const noexcept {
    const auto drifted_ns = static_cast<std::int64_t>(drift_ * static_cast<double>(true_ns));
    return start_ns_ + true_ns - slept_ns_ + static_cast<std::uint64_t>(drifted_ns);
  }
  void sleep(std::uint64_t from_true_ns, std::uint64_t for_ns) noexcept {
    slept_ns_ += at(from_true_ns + for_ns) - at(from_true_ns);
  }

 private:
  std::uint64_t start_ns_, slept_ns_ = 0;
  double drift_;
};

/// How long what is sent is on its way, drawn evenly, and what share of it is lost.
struct LinkSpec {
  double least_there_ms, most_there_ms;  // to the other machine
  double least_back_ms, most_back_ms;
  double loss;
  [[nodiscard]] double longest_trip_ns() const { return 1e6 * (most_there_ms + most_back_ms); }
};

/// Two relays' statuses over such a link, in virtual time.
class TwoMachines {
 public:
  static constexpr std::uint64_t kStep_ns = 1'000'000, kOurId = 11, kOtherId = 22;

  TwoMachines(std::uint32_t seed, const LinkSpec& link, MachineClock ours, MachineClock others)
      : random_(seed), link_(link) {
    sides_.push_back({kOurId, Role::kHand, ours});
    sides_.push_back({kOtherId, Role::kSimulation, others});
  }

  /// A millisecond passes: what is due comes, what is due is sent.
  void step() {
    true_ns_ += kStep_ns;
    for (std::size_t i = 0; i < 2; ++i) {
      hear(sides_[i]);
      say(sides_[i], sides_[1 - i], i == 0);
    }
  }
  /// From now on the ways are those.
  void change(const LinkSpec& link) { link_ = link; }
  /// The cable is out for so long: what is on its way is lost, and neither clock stands still.
  void pass(std::uint64_t for_ns) {
    true_ns_ += for_ns;
    for (Side& side : sides_) side.coming.clear();
  }
  /// One machine sleeps while nothing is said: number 0 is ours, 1 the other.
  void sleep(std::size_t machine, std::uint64_t for_ns) {
    sides_[machine].clock.sleep(true_ns_, for_ns);
    true_ns_ += for_ns;
  }

  [[nodiscard]] const ClockOffset& offset() const { return sides_[0].side.clock(); }
  [[nodiscard]] std::uint64_t our_ns() const { return sides_[0].clock.at(true_ns_); }
  [[nodiscard]] std::uint64_t others_ns() const { return sides_[1].clock.at(true_ns_); }
  [[nodiscard]] std::int64_t true_offset_ns() const {
    return static_cast<std::int64_t>(others_ns()) - static_cast<std::int64_t>(our_ns());
  }
  /// The exchanges that counted so far, and the last of them.
  [[nodiscard]] std::size_t exchanges() const { return exchanges_; }
  [[nodiscard]] const Exchange& last_exchange() const { return last_exchange_; }

 private:
  struct Side {
    Side(std::uint64_t id, Role role, MachineClock own)
        : clock(own), side(id, role, "s", [](const std::string&) {}) {}
    MachineClock clock;
    OtherSide side;
    std::vector<std::pair<std::uint64_t, Status>> coming;  // by true time
    std::uint64_t next_status_ns = 0;
  };

  void hear(Side& side) {
    const std::uint64_t now_ns = side.clock.at(true_ns_);
    std::vector<std::pair<std::uint64_t, Status>> later;
    for (const auto& [due_ns, status] : side.coming) {
      if (due_ns > true_ns_) {
        later.emplace_back(due_ns, status);
        continue;
      }
      const ClockOffset before = side.side.clock();
      side.side.hear(status, now_ns);
      const bool is_taken = std::memcmp(&side.side.clock(), &before, sizeof before) != 0;
      if (&side != sides_.data() || !is_taken) continue;
      ++exchanges_;
      last_exchange_ = {status.echo_sent_ns, status.echo_received_ns, status.sent_ns, now_ns};
    }
    side.coming = std::move(later);
    side.side.look(now_ns);
  }

  void say(Side& from, Side& to, bool is_ours) {
    const std::uint64_t now_ns = from.clock.at(true_ns_);
    if (now_ns < from.next_status_ns) return;
    from.next_status_ns = now_ns + from.side.status_period_ns();
    const Status status = from.side.next_status(now_ns);
    const double way_ms =
        is_ours ? std::uniform_real_distribution(link_.least_there_ms, link_.most_there_ms)(random_)
                : std::uniform_real_distribution(link_.least_back_ms, link_.most_back_ms)(random_);
    if (std::bernoulli_distribution(link_.loss)(random_)) return;
    to.coming.emplace_back(true_ns_ + static_cast<std::uint64_t>(1e6 * way_ms), status);
  }

  std::mt19937 random_;
  LinkSpec link_;
  std::uint64_t true_ns_ = 0;
  std::vector<Side> sides_;
  std::size_t exchanges_ = 0;
  Exchange last_exchange_{};
};

}  // namespace stillgrid::scene_relay

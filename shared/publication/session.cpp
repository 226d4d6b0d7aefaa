#include "shared/publication/session.hpp"

#include <chrono>
#include <functional>
#include <utility>
#include <vector>

#include "shared/publication/hands.hpp"
#include "shared/publication/lockstep.hpp"

namespace stillgrid::publication {
namespace {

constexpr std::uint64_t kPeerPatience_ns = 10'000'000'000;

std::uint64_t monotonic_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch() /
                                    std::chrono::nanoseconds(1));
}

}  // namespace

HandSession::HandSession(std::string session, SessionLock lock, const StaticScene& fixed,
                         const SessionSpec& spec)
    : name_(std::move(session)),
      writer_(std::move(lock), fixed, spec.moving_count, spec.period_ns, spec.clock, spec.start_ns,
              spec.readers),
      tool_(name_, proto::SegmentKind::kTool, proto::kToolLayoutHash, spec.clock,
            [clock = spec.clock, report = spec.report](const std::string& refusal) {
              // Lockstep cannot go on without its peer; real time can, until a better one comes.
              if (clock == proto::Clock::kVirtual) throw SegmentError(refusal);
              if (report) report(refusal);
            }) {}

const ToolView* HandSession::living_tool() noexcept {
  const ToolView* view = tool_.acquire();
  // In lockstep a peer that has died ends the run, and no poll asks about it here.
  const bool is_real = view != nullptr && view->header().clock == proto::Clock::kMonotonic;
  return is_real && !tool_.writer_alive() ? nullptr : view;
}

std::optional<proto::ToolState> HandSession::take_tool() noexcept {
  const ToolView* view = living_tool();
  if (view == nullptr) {
    last_tool_.reset();
  } else if (const auto state = view->read()) {
    last_tool_ = state;  // else the last good one stands
  }
  return last_tool_;
}

Session::Session(const SessionSpec& spec, SessionLock lock, std::span<const HandScene> hands) {
  std::vector<std::string> names;
  std::vector<SessionLock> locks;
  const bool is_unnamed = hands.size() == 1 && hands.front().name.empty();
  // All before the first segment: who sees one knows all hands.
  for (const HandScene& hand : hands) {
    names.push_back(hand_session(spec.name, hand.name));
    if (!is_unnamed) locks.emplace_back(names.back(), proto::SegmentKind::kScene);
  }
  if (is_unnamed)
    locks.push_back(std::move(lock));
  else
    lock_.emplace(std::move(lock));
  for (std::size_t hand = 0; hand < names.size(); ++hand)
    hands_.emplace_back(std::move(names[hand]), std::move(locks[hand]), hands[hand].fixed, spec);
}

void Session::promise(std::uint64_t proto::SegmentHeader::*word, std::uint64_t time_ns) noexcept {
  for (HandSession& hand : hands_)
    double_buffer::HardwareAtomics::store(hand.writer().header().*word, time_ns,
                                          std::memory_order_release);
}

bool LockstepPeers::wait_for_arrival(std::uint64_t until_ns) {
  if (began_ns_ == 0) began_ns_ = monotonic_ns();
  for (std::size_t hand = 0; hand < session_.hands().size(); ++hand) {
    while (view(hand) == nullptr) {
      if (stop_) return false;
      session_.hands()[hand].tool().poll();
      const std::uint64_t now_ns = monotonic_ns();
      if (now_ns > began_ns_ + kPeerPatience_ns)
        throw SegmentError("no haptic_server --lockstep in session '" +
                           session_.hands()[hand].name() + "' after 10 s");
      if (now_ns >= until_ns) return false;
    }
  }
  return true;
}

bool LockstepPeers::wait(std::uint64_t proto::SegmentHeader::*promise, std::uint64_t value,
                         std::uint64_t until_ns) {
  for (std::size_t hand = 0; hand < session_.hands().size(); ++hand) {
    const ToolView& peer = *view(hand);
    const auto word = [&] {
      return double_buffer::HardwareAtomics::load(peer.reader().live().*promise,
                                                  std::memory_order_acquire);
    };
    bool is_late = false;
    const auto still_there = [&] {
      is_late = until_ns != proto::kNever && monotonic_ns() >= until_ns;
      return !is_late && peer.reader().writer_alive();
    };
    const WaitResult result =
        wait_for_promise(std::cref(word), value, std::cref(still_there), stop_);
    if (result == WaitResult::kPeerGone && !is_late)
      throw SegmentError("the haptic_server" + of_hand(hand) +
                         " died; lockstep cannot go on without it");
    if (result != WaitResult::kReached) return false;
  }
  return true;
}

bool LockstepPeers::have_ended() {
  for (std::size_t hand = 0; hand < session_.hands().size(); ++hand)
    if (double_buffer::HardwareAtomics::load(view(hand)->reader().live().lockstep_sample_ns,
                                             std::memory_order_acquire) != proto::kNever)
      return false;
  return true;
}

std::string LockstepPeers::of_hand(std::size_t hand) const {
  return session_.hands().size() > 1 ? " of '" + session_.hands()[hand].name() + "'" : "";
}

}  // namespace stillgrid::publication

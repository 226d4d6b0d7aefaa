#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "shared/publication/scene_segment.hpp"
#include "shared/publication/segment_watch.hpp"
#include "shared/publication/tool_segment.hpp"

namespace stillgrid::publication {

/// A hand, and what is published for it once.
struct HandScene {
  std::string name;  // empty: the only hand, without a name
  StaticScene fixed;
};

/// Properties of a session. The simulation gives them as it opens the session.
struct SessionSpec {
  std::string name;
  std::size_t moving_count = 0;
  std::uint64_t period_ns = 0;
  proto::Clock clock = proto::Clock::kMonotonic;
  std::uint64_t start_ns = 0;
  std::optional<gid_t> readers = std::nullopt;
  /// Told of each refusal of a tool's segment once, in real time; in lockstep it is thrown.
  std::function<void(const std::string&)> report;
};

/// One hand's side of the session: its segment of the scene, and its tool's as it comes and goes.
class HandSession {
 public:
  /// session: SESSION+HAND. Throws SegmentError.
  HandSession(std::string session, SessionLock lock, const StaticScene& fixed,
              const SessionSpec& spec);

  /// The tool's newest state; none while its haptic_server is away, the last good one where it
  /// was overtaken. Realtime: wait-free.
  [[nodiscard]] std::optional<proto::ToolState> take_tool() noexcept;

  /// The tool's segment; null while its haptic_server is away. Thread: as take_tool(). Realtime:
  /// wait-free.
  [[nodiscard]] const ToolView* living_tool() noexcept;

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] SceneWriter& writer() noexcept { return writer_; }
  [[nodiscard]] SegmentWatch<ToolView>& tool() noexcept { return tool_; }

 private:
  std::string name_;
  SceneWriter writer_;
  SegmentWatch<ToolView> tool_;
  std::optional<proto::ToolState> last_tool_;
};

/// The simulation's side of a session, by hand. Hands share no segment, so that none can touch
/// another (docs/decisions/0020-a-scene-segment-a-hand.md).
class Session {
 public:
  /// lock: of the session itself, kept beside those of its hands. Throws SegmentError.
  Session(const SessionSpec& spec, SessionLock lock, std::span<const HandScene> hands);

  [[nodiscard]] std::deque<HandSession>& hands() noexcept { return hands_; }

  /// Says to every hand's peer that nothing of ours comes before time_ns: docs/protocol.md,
  /// "Lockstep".
  void promise(std::uint64_t proto::SegmentHeader::*word, std::uint64_t time_ns) noexcept;

 private:
  std::optional<SessionLock> lock_;  // unless its only hand has it
  std::deque<HandSession> hands_;
};

/// Waits for the promises of every hand's peer, and turns what goes wrong into an error.
class LockstepPeers {
 public:
  LockstepPeers(Session& session, const std::atomic<bool>& stop) : session_(session), stop_(stop) {}

  /// Throws SegmentError where one has not come within 10 s. False when stopped, or at until_ns.
  bool wait_for_arrival(std::uint64_t until_ns = proto::kNever);

  /// False when stopped, or at until_ns of the monotonic clock. Throws SegmentError where a peer
  /// died.
  bool wait(std::uint64_t proto::SegmentHeader::*promise, std::uint64_t value,
            std::uint64_t until_ns = proto::kNever);

  /// Returns whether every peer has ended its run in order. Pre: all have arrived.
  [[nodiscard]] bool have_ended();

 private:
  const ToolView* view(std::size_t hand) { return session_.hands()[hand].tool().acquire(); }
  [[nodiscard]] std::string of_hand(std::size_t hand) const;

  Session& session_;
  const std::atomic<bool>& stop_;
  std::uint64_t began_ns_ = 0;  // to wait for arrival
};

}  // namespace stillgrid::publication

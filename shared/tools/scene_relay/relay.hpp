#pragma once

#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "proto/segment_header.hpp"
#include "shared/realtime/histogram.hpp"
#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/scene_relay/messages.hpp"
#include "shared/tools/scene_relay/network.hpp"
#include "shared/tools/scene_relay/other_side.hpp"

namespace stillgrid::scene_relay {

struct RelayOptions {
  std::string session;  // SESSION, or SESSION+HAND
  NetworkOptions network;
  std::optional<double> duration_s;
  std::optional<gid_t> readers;    // a group that may read what it publishes here
  bool has_deltas = true;          // beside the simulation
  std::optional<double> rate_hz;   // likewise: snapshots a second at most
  std::optional<double> deadband;  // beside the hand: share of the tool's velocity
};

/// What a relay counted, of what it received and sent.
struct RelayReport {
  Role role = Role::kHand;
  proto::RelayFigures figures{};
  std::uint64_t sent = 0, sent_bytes = 0;   // snapshots or tool samples
  std::uint64_t keyframes = 0, deltas = 0;  // of snapshots sent
  std::uint64_t withheld = 0;               // tool samples, by the deadband
  std::uint64_t without_keyframe = 0;       // deltas whose keyframe was not there
  std::uint64_t segments = 0;               // made of what came
  realtime::Histogram way_ns;               // of each that came, since its publication
  realtime::Histogram age_ns;               // of the newest, at every look
};

/// Thrown by neither: publishes SESSION's scene to the other machine, and its tool here, until it
/// is stopped. Throws NetworkError, SegmentError.
void relay_beside_simulation(const RelayOptions& options, RelayReport& report,
                             const std::atomic<bool>& stop);
/// The same the other way round.
void relay_beside_hand(const RelayOptions& options, RelayReport& report,
                       const std::atomic<bool>& stop);

/// JSON (docs/formats.md). Throws std::runtime_error naming the file.
void write_report(const RelayReport& report, const std::filesystem::path& file);

/// How often a relay looks at shared memory.
inline constexpr std::uint64_t kLook_ns = 500'000;
/// A snapshot that took longer, and a tool that was silent for longer, is not shown.
inline constexpr std::uint64_t kLongestWay_ns = 250'000'000;

/// Topic NAME of a session: "stillgrid/2/SESSION/NAME". What is no letter and no digit of SESSION
/// is _ and its two hexadecimal digits there, for topics bear fewer characters.
[[nodiscard]] std::string topic_of(const std::string& session, const char* name);
/// That on which relays of all protocols greet.
[[nodiscard]] std::string greeting_topic(const std::string& session);

/// What both sides do alike: the other side, its clock, and the counts.
class RelayLink {
 public:
  RelayLink(const RelayOptions& options, Role role, RelayReport& report);

  /// Until it is told to stop, or for as long as was asked: wake(now_ns) whenever something may
  /// have come, and every kLook_ns look(now_ns) after it.
  template <class Wake, class Look>
  void run(const std::atomic<bool>& stop, const Wake& wake, const Look& look) {
    std::uint64_t next_ns = realtime::monotonic_ns();
    const std::uint64_t end_ns =
        duration_s_ ? next_ns + realtime::to_ns(*duration_s_) : proto::kNever;
    while (!stop) {
      participant_.wait(next_ns);
      const std::uint64_t now_ns = realtime::monotonic_ns();
      if (now_ns >= end_ns) break;
      wake(now_ns);
      if (now_ns < next_ns) continue;
      next_ns = std::max(next_ns + kLook_ns, now_ns);
      look(now_ns);
    }
    (void)figures();
  }

  [[nodiscard]] const Participant& participant() const noexcept { return participant_; }
  [[nodiscard]] std::uint64_t relay_id() const noexcept { return relay_id_; }
  [[nodiscard]] const OtherSide& other() const noexcept { return other_; }
  [[nodiscard]] const ClockOffset& clock() const noexcept { return other_.clock(); }
  [[nodiscard]] std::string topic(const char* name) const { return topic_of(session_, name); }

  /// Takes greetings and statuses; whether a status of the other side came.
  bool hear(std::uint64_t now_ns);
  /// What a side tells in a status of itself.
  struct Said {
    std::uint64_t segment_epoch = 0;  // of the segment that it reads
    std::uint64_t scene_epoch = 0, keyframe_id = 0;
    std::uint64_t received = 0;  // number of the last snapshot message
    bool operator==(const Said&) const = default;
  };
  /// Sends greeting and status when it is time, or at once where another thing is to be said.
  void say(std::uint64_t now_ns, const Said& said);

  /// Whether a message is the other side's and newer than those before; counts it.
  ///
  /// A number that leaps further ahead than any sender counts meanwhile is refused; one that stays
  /// ahead of all that comes for kLongestWay_ns, as a flipped bit made it, is forgotten.
  bool accept(std::uint64_t relay_id, std::uint64_t number, std::size_t bytes,
              std::uint64_t now_ns);
  /// Whether what was stamped then, on the other's clock, came in time; counts it if not.
  bool came_in_time(std::uint64_t stamp_ns, std::uint64_t now_ns);
  void refuse(const std::string& line);
  /// Told once, until something else is.
  void warn(const std::string& line);

  /// Brings the report's figures up to date.
  [[nodiscard]] const proto::RelayFigures& figures() noexcept;

 private:
  RelayReport& report_;
  std::optional<double> duration_s_;
  std::string session_;
  std::uint64_t relay_id_;
  Participant participant_;
  OtherSide other_;
  dds_entity_t greetings_out_, greetings_in_, status_out_, status_in_;
  std::uint64_t next_status_ns_ = 0, next_greeting_ns_ = 0, number_ = 0, number_of_ = 0,
                accepted_ns_ = 0;
  Said said_;
  std::string last_warning_;
};

}  // namespace stillgrid::scene_relay

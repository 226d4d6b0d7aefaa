#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "proto/tool_segment.hpp"
#include "shared/publication/scene_segment.hpp"

/// Both directions of a network between the two rates, in virtual time. The same seed carries the
/// same packets alike.
namespace stillgrid::laboratory {

/// What a packet meets, either way.
struct PacketPath {
  double delay_s = 0.0;       // one way
  double delay_jitter = 0.0;  // each packet takes delay_s (1 + u), u uniform in +- this, below 1
  double loss = 0.0;          // of packets, each by itself, below 1
};

/// A snapshot goes in fragments of so many bytes: Cyclone DDS's own, one to a packet.
inline constexpr std::size_t kFragment_bytes = 1344;

/// A snapshot that was longer on its way is not shown.
inline constexpr std::uint64_t kOldestSnapshot_ns = 250'000'000;

/// Packets by a path: whether each comes, and when.
class Packets {
 public:
  Packets(const PacketPath& path, std::uint64_t seed);

  [[nodiscard]] bool is_lost() { return path_.loss > 0.0 && share_(random_) < path_.loss; }
  [[nodiscard]] std::uint64_t delay_ns();

 private:
  PacketPath path_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> share_{0.0, 1.0};
};

/// A tool's sample, and when it came.
struct ArrivedSample {
  proto::ToolState sample;
  std::uint64_t arrival_ns = 0;
};

/// Tool samples, best effort: one is lost with its packet, and an older one never replaces a newer.
class ToolLink {
 public:
  ToolLink(const PacketPath& path, std::uint64_t seed) : packets_(path, seed) {}

  /// Pre: in the order of time.
  void send(const proto::ToolState& sample);

  /// The newest of those that came up to now_ns. Pre: now_ns is not before the last call's.
  [[nodiscard]] const std::optional<ArrivedSample>& newest(std::uint64_t now_ns);

 private:
  Packets packets_;
  std::vector<ArrivedSample> in_flight_;
  std::optional<ArrivedSample> newest_;
};

/// What a snapshot tells, on its way.
struct SentSnapshot {
  publication::SnapshotTimes times;          // as published by the simulation
  std::vector<proto::SphereRecord> spheres;  // of which the history stays behind
  std::vector<proto::FieldRecord> fields;    // likewise
};

struct ArrivedSnapshot {
  SentSnapshot snapshot;
  std::uint64_t arrival_ns = 0;
};

/// Snapshots, reliable, the last ones kept: a fragment that is lost is asked for again, a round
/// trip at least, until it has come or so many newer snapshots were sent that the whole is kept no
/// longer. What comes after a newer one is not shown. How many bits a second a network bears is not
/// modelled, nor that acknowledgements wait.
class SnapshotLink {
 public:
  /// bytes: of each snapshot. kept: by the sender. Pre: kept > 0.
  SnapshotLink(const PacketPath& path, std::size_t bytes, std::uint64_t seed, std::size_t kept = 1);

  /// Sent at snapshot.times.publish_ns. Pre: in the order of time.
  void send(SentSnapshot snapshot);

  /// Those that came up to now_ns, in the order in which they did, each newer than the last.
  [[nodiscard]] std::vector<ArrivedSnapshot> take(std::uint64_t now_ns);

  /// Snapshots that will never be shown, by the reason.
  [[nodiscard]] std::uint64_t replaced() const noexcept { return replaced_; }
  [[nodiscard]] std::uint64_t late() const noexcept { return late_; }

 private:
  struct InFlight : ArrivedSnapshot {
    std::uint64_t last_asked_ns = 0;  // when the sender was last asked for a part; 0: never
    std::size_t newer = 0;            // sent since
  };

  Packets packets_;
  std::size_t fragments_, kept_;
  std::vector<InFlight> in_flight_;
  std::uint64_t shown_ns_ = 0;  // when the last one that was taken was sent
  bool has_shown_ = false;
  std::uint64_t replaced_ = 0, late_ = 0;
};

}  // namespace stillgrid::laboratory

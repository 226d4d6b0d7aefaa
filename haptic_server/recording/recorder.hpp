#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "haptic_server/recording/block_file.hpp"
#include "haptic_server/recording/recording_format.hpp"
#include "haptic_server/recording/scene_sampler.hpp"
#include "shared/reading/segment_follower.hpp"
#include "shared/realtime/spsc_ring.hpp"

namespace stillgrid::recording {

/// What a recording with scenes needs to know beside the rows.
struct RecordingSource {
  std::string session;                // whose scene is followed; empty: note_scene() tells of it
  std::uint64_t clock_offset_ns = 0;  // from the clock of rows and scenes to that of messages
};

/// What is wrong with a name of a file to record to, in a line; empty: nothing.
[[nodiscard]] std::string name_complaint(const std::string& file);

/// Writes rows to a file from a thread of its own, through a lock-free ring: MCAP where the file is
/// named so, else CSV.
///
/// The file grows by batches, some 100 a second: however the process ends, what is there is whole
/// rows but for the last; of MCAP whole chunks, four a second. Rows that a full disk refuses wait
/// in the ring, 16 s of them at 1 kHz, and are written when it has room again. The rows in the file
/// and those lost make up the rows recorded, always.
class Recorder {
 public:
  /// Opens the file. Throws std::runtime_error if it cannot be written. What an earlier recording
  /// left there stays until the first row comes; a file that is new goes again if none does.
  Recorder(const std::filesystem::path& file, const std::string& scene, const std::string& device,
           const RecordingHead& more = {}, const RecordingSource& source = {});

  /// Writes what is left.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  Recorder(Recorder&&) = delete;
  Recorder& operator=(Recorder&&) = delete;

  /// Takes a row, or counts it as lost when the ring is full. Thread: the loop's. Realtime:
  /// wait-free.
  void record(const TickRow& row) noexcept;

  /// Takes a row, waiting for room as long as the file takes rows: for lockstep, where nothing may
  /// be lost but to a full disk. Not real-time.
  void record_waiting(const TickRow& row) noexcept;

  /// Takes what the scene shows now, to stand before the next row: for lockstep, where the thread
  /// that writes would see it sooner or later by chance. Not real-time. Thread: the loop's.
  void note_scene(const publication::SceneView& scene);

  /// Writes what is left and ends. Returns the rows that were not written, by a full ring or a
  /// failing file. Nothing may be recorded after. Thread: the loop's, when it is over.
  std::uint64_t finish();

 private:
  struct NotedScene {
    std::uint64_t before_row;
    SceneSample sample;
  };

  void run(const std::stop_token& stop);
  void begin_files();
  int write_rows();
  void follow_scene();
  void add_noted_scenes();

  std::filesystem::path path_;
  BlockFile file_;
  std::unique_ptr<RecordingFormat> format_;
  realtime::SpscRing<TickRow> ring_;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<bool> has_rows_ = false, is_failing_ = false;

  SceneSampler sampler_;  // of the thread that looks at the scene
  std::optional<reading::SegmentFollower> follower_;
  std::mutex noted_mutex_;
  std::deque<NotedScene> noted_;
  std::uint64_t pushed_ = 0, popped_ = 0;  // rows, of either end of the ring
  std::jthread thread_;
};

}  // namespace stillgrid::recording

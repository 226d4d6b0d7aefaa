#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "haptic_server/recording/line_file.hpp"
#include "shared/realtime/spsc_ring.hpp"

namespace stillgrid::recording {

/// One tick as recorded; docs/formats.md, "Recorded trajectories". Scene frame, SI units.
struct TickRow {
  double time_s = 0.0;  // since the loop began
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();     // that the device was told
  Eigen::Vector3d rendered_N = Eigen::Vector3d::Zero();  // before the safety chain
  std::uint64_t snapshot_id = 0;
  double alpha = 1.0;
  int contacts = 0;
  double age_s = 0.0;
  std::uint64_t tick_ns = 0;
  std::uint32_t flags = 0;
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();             // that the device was told
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  // of the tool
};

/// A row as a line of the CSV, without its end; numbers in the shortest form that reads back the
/// same.
void append_row(const TickRow& row, std::string& line);

/// Lines "# key: value" at the head of a recording.
using RecordingHead = std::vector<std::pair<std::string, std::string>>;

/// Writes rows to a file from a thread of its own, through a lock-free ring.
///
/// The file grows by batches, some 100 a second: however the process ends, what is there is whole
/// rows but for the last. Rows that a full disk refuses wait in the ring, 16 s of them at 1 kHz,
/// and are written when it has room again. The rows in the file and those lost make up the rows
/// recorded, always.
class Recorder {
 public:
  /// Opens the file and writes its head. Throws std::runtime_error if it cannot be written.
  Recorder(const std::filesystem::path& file, const std::string& scene, const std::string& device,
           const RecordingHead& more = {});

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

  /// Writes what is left and ends. Returns the rows that were not written, by a full ring or a
  /// failing file. Nothing may be recorded after. Thread: the loop's, when it is over.
  std::uint64_t finish();

 private:
  void run(const std::stop_token& stop);
  int write_rows();

  std::filesystem::path path_;
  LineFile file_;
  std::string line_;
  realtime::SpscRing<TickRow> ring_;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<bool> is_failing_ = false;
  std::jthread thread_;
};

}  // namespace stillgrid::recording

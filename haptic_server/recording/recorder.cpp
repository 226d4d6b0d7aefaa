#include "haptic_server/recording/recorder.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::recording {
namespace {

constexpr std::size_t kRingRows = 16384;  // 16 s at 1 kHz
constexpr auto kBatchPause = std::chrono::milliseconds(10);
constexpr std::size_t kBatchBytes = 65536;
constexpr const char* kColumns =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,fx_N,fy_N,fz_N,rendered_fx_N,rendered_fy_N,"
    "rendered_fz_N,snapshot_id,alpha,contacts,age_s,tick_ns,flags,tx_N_m,ty_N_m,tz_N_m,"
    "qx,qy,qz,qw";

template <class Number>
void append(std::string& line, Number value) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  line.append(text.data(), end);
  line += ',';
}

void append(std::string& line, const Eigen::Vector3d& v) {
  append(line, v.x());
  append(line, v.y());
  append(line, v.z());
}

/// Without what would end the line or mean something to a terminal.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

}  // namespace

void append_row(const TickRow& row, std::string& line) {
  append(line, row.time_s);
  append(line, row.position_m);
  append(line, row.velocity_m_s);
  append(line, row.force_N);
  append(line, row.rendered_N);
  append(line, row.snapshot_id);
  append(line, row.alpha);
  append(line, row.contacts);
  append(line, row.age_s);
  append(line, row.tick_ns);
  const char* separator = "";
  for (std::size_t i = 0; i < safety::kSafetyFlagNames.size(); ++i) {
    if ((row.flags & (1U << i)) == 0) continue;
    line += separator;
    line += safety::kSafetyFlagNames[i];
    separator = "|";
  }
  line += ',';
  append(line, row.torque_N_m);
  for (const double number : row.orientation.coeffs()) append(line, number);
  line.pop_back();
}

Recorder::Recorder(const std::filesystem::path& file, const std::string& scene,
                   const std::string& device, const RecordingHead& more)
    : path_(file), file_(file), ring_(kRingRows) {
  file_.add("# scene: " + printable(scene));
  file_.add("# device: " + printable(device));
  for (const auto& [key, value] : more) file_.add("# " + key + ": " + printable(value));
  file_.add(kColumns);
  if (const int error = file_.flush(); error != 0)
    throw std::runtime_error("--record: " + file.string() +
                             " could not be written: " + std::strerror(error));
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Recorder::~Recorder() {
  (void)finish();
}

std::uint64_t Recorder::finish() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
    lost_ += file_.end();
    for (TickRow row; ring_.pop(row);) ++lost_;
  }
  return lost_;
}

void Recorder::record(const TickRow& row) noexcept {
  if (!ring_.push(row)) lost_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::record_waiting(const TickRow& row) noexcept {
  while (!ring_.push(row)) {
    if (is_failing_) {
      ++lost_;
      return;
    }
    std::this_thread::yield();
  }
}

void Recorder::run(const std::stop_token& stop) {
  bool has_failed = false;
  bool is_last = false;
  while (!is_last) {
    is_last = stop.stop_requested();  // asked before the rows are taken: none comes after
    const int error = write_rows();
    is_failing_ = error != 0;
    if (error != 0 && !std::exchange(has_failed, true))
      spdlog::warn("--record: {} could not be written: {}; trying on", path_.string(),
                   std::strerror(error));
    if (!is_last) std::this_thread::sleep_for(kBatchPause);
  }
}

/// Writes what the ring holds. Returns 0, or the error number; what was not written waits.
int Recorder::write_rows() {
  for (bool is_empty = false; !is_empty;) {
    TickRow row;
    while (file_.waiting_bytes() < kBatchBytes) {
      is_empty = !ring_.pop(row);
      if (is_empty) break;
      line_.clear();
      append_row(row, line_);
      file_.add(line_);
    }
    if (const int error = file_.flush(); error != 0) return error;
  }
  return 0;
}

}  // namespace stillgrid::recording

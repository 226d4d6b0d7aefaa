#include "haptic_server/recording/recorder.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "haptic_server/safety/force_guard.hpp"

namespace stillgrid {
namespace {

constexpr std::size_t kRingRows = 16384;  // 16 s at 1 kHz
constexpr auto kBatchPause = std::chrono::milliseconds(10);
constexpr const char* kColumns =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,fx_N,fy_N,fz_N,rendered_fx_N,rendered_fy_N,"
    "rendered_fz_N,generation,alpha,contacts,age_s,tick_ns,flags,tx_Nm,ty_Nm,tz_Nm\n";

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

}  // namespace

void append_row(const TickRow& row, std::string& line) {
  append(line, row.time_s);
  append(line, row.position_m);
  append(line, row.velocity_m_s);
  append(line, row.force_N);
  append(line, row.rendered_N);
  append(line, row.generation);
  append(line, row.alpha);
  append(line, row.contacts);
  append(line, row.age_s);
  append(line, row.tick_ns);
  const char* separator = "";
  for (std::size_t i = 0; i < kSafetyFlagNames.size(); ++i) {
    if ((row.flags & (1U << i)) == 0) continue;
    line += separator;
    line += kSafetyFlagNames[i];
    separator = "|";
  }
  line += ',';
  append(line, row.torque_N_m);
  line.pop_back();
}

Recorder::Recorder(const std::filesystem::path& file, const std::string& scene,
                   const std::string& device)
    : file_(std::fopen(file.c_str(), "w")), ring_(kRingRows) {
  if (!file_)
    throw std::runtime_error("--record: value '" + file.string() +
                             "': expected a file that can be written: " + std::strerror(errno));
  std::fprintf(file_.get(), "# scene: %s\n# device: %s\n%s", scene.c_str(), device.c_str(),
               kColumns);
  if (std::fflush(file_.get()) != 0)
    throw std::runtime_error("--record: " + file.string() +
                             " could not be written: " + std::strerror(errno));
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      write_rows();
      std::this_thread::sleep_for(kBatchPause);
    }
    write_rows();
  });
}

Recorder::~Recorder() {
  (void)finish();
}

std::uint64_t Recorder::finish() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  return lost_.load(std::memory_order_relaxed);
}

void Recorder::record(const TickRow& row) noexcept {
  if (!ring_.push(row)) lost_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::record_waiting(const TickRow& row) noexcept {
  while (!ring_.push(row)) std::this_thread::yield();
}

void Recorder::write_rows() {
  std::string line;
  TickRow row;
  std::uint64_t rows = 0;
  bool written = true;
  for (; ring_.pop(row); ++rows) {
    line.clear();
    append_row(row, line);
    line += '\n';
    written = std::fwrite(line.data(), 1, line.size(), file_.get()) == line.size() && written;
  }
  if (rows == 0) return;
  written = std::fflush(file_.get()) == 0 && written;
  if (!written) lost_.fetch_add(rows, std::memory_order_relaxed);
}

}  // namespace stillgrid

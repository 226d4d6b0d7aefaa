#include "haptic_server/recording/recorder.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "haptic_server/recording/csv_recording.hpp"
#include "haptic_server/recording/mcap_recording.hpp"

namespace stillgrid::recording {
namespace {

constexpr std::size_t kRingRows = 16384;  // 16 s at 1 kHz
constexpr auto kBatchPause = std::chrono::milliseconds(10);
constexpr std::size_t kBatchBytes = 65536;

/// Without what would end the line or mean something to a terminal.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

/// In small letters.
std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace

std::string name_complaint(const std::string& file) {
  const std::string ending = ending_of(file);
  // Pipes and devices have none.
  if (!file.empty() && (ending.empty() || ending == ".csv" || ending == ".mcap")) return {};
  return "value '" + file + "': expected FILE.csv or FILE.mcap, which is compressed";
}

Recorder::Recorder(const std::filesystem::path& file, const std::string& scene,
                   const std::string& device, const RecordingHead& more,
                   const RecordingSource& source)
    : path_(file), file_(file), ring_(kRingRows) {
  RecordingHead head = {{"scene", printable(scene)}, {"device", printable(device)}};
  for (const auto& [key, value] : more) head.emplace_back(key, printable(value));
  if (ending_of(file) == ".mcap")
    format_ = std::make_unique<McapRecording>(file_, head, source.clock_offset_ns);
  else
    format_ = std::make_unique<CsvRecording>(file_, file, head);
  if (const int error = file_.flush(); error != 0)
    throw std::runtime_error("--record: " + file.string() +
                             " could not be written: " + std::strerror(error));
  if (format_->holds_scenes() && !source.session.empty())
    follower_.emplace(source.session, proto::SegmentKind::kScene);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Recorder::~Recorder() {
  (void)finish();
}

std::uint64_t Recorder::finish() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
    if (has_rows_) format_->finish();
    lost_ += file_.end();
    for (TickRow row; ring_.pop(row);) ++lost_;
  }
  return lost_;
}

void Recorder::record(const TickRow& row) noexcept {
  has_rows_.store(true, std::memory_order_relaxed);
  if (!ring_.push(row)) lost_.fetch_add(1, std::memory_order_relaxed);
}

void Recorder::record_waiting(const TickRow& row) noexcept {
  has_rows_ = true;
  while (!ring_.push(row)) {
    if (is_failing_) {
      ++lost_;
      return;
    }
    std::this_thread::yield();
  }
  ++pushed_;
}

void Recorder::note_scene(const publication::SceneView& scene) {
  if (!format_->holds_scenes() || is_failing_) return;
  auto sample = sampler_.sample(scene);
  if (!sample) return;
  const std::scoped_lock lock(noted_mutex_);
  noted_.push_back({pushed_, std::move(*sample)});
}

void Recorder::begin_files() {
  file_.begin();
  try {
    format_->begin();
  } catch (const std::exception& error) {
    spdlog::warn("--record: {}", error.what());
  }
}

void Recorder::run(const std::stop_token& stop) {
  while (!has_rows_ && !stop.stop_requested()) std::this_thread::sleep_for(kBatchPause);
  if (!has_rows_) return;
  begin_files();
  bool has_failed = false;
  bool is_last = false;
  while (!is_last) {
    is_last = stop.stop_requested();  // asked before the rows are taken: none comes after
    if (follower_ && !is_failing_) follow_scene();
    const int error = write_rows();
    is_failing_ = error != 0;
    if (error != 0 && !std::exchange(has_failed, true))
      spdlog::warn("--record: {} could not be written: {}; trying on", path_.string(),
                   std::strerror(error));
    if (!is_last) std::this_thread::sleep_for(kBatchPause);
  }
}

void Recorder::follow_scene() {
  follower_->look();
  if (const publication::SceneView* scene = follower_->scene())
    if (const auto sample = sampler_.sample(*scene)) format_->add_scene(*sample);
}

/// Those that were noted before the row to come.
void Recorder::add_noted_scenes() {
  const std::scoped_lock lock(noted_mutex_);
  for (; !noted_.empty() && noted_.front().before_row <= popped_; noted_.pop_front())
    format_->add_scene(noted_.front().sample);
}

/// Writes what the ring holds. Returns 0, or the error number; what was not written waits.
int Recorder::write_rows() {
  for (bool is_empty = false; !is_empty;) {
    TickRow row;
    while (file_.waiting_bytes() < kBatchBytes) {
      is_empty = !ring_.pop(row);
      if (is_empty) break;
      if (format_->holds_scenes()) add_noted_scenes();
      format_->add_row(row);
      ++popped_;
    }
    if (const int error = file_.flush(); error != 0) return error;
  }
  return 0;
}

}  // namespace stillgrid::recording

#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "shared/tools/scene_viewer/other_hands.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"
#include "shared/tools/scene_viewer/tool_sampler.hpp"
#include "shared/tools/scene_viewer/view_file.hpp"
#include "shared/tools/scene_viewer/view_source.hpp"
#include "shared/tools/scene_viewer/writer_command.hpp"

namespace stillgrid::scene_viewer {

struct LiveOptions {
  std::string session;  // of the hand that is shown in full
  double frames_per_s = 30.0;
  Surfaces surfaces;
  std::filesystem::path save;  // empty: nothing is saved
};

/// A session as it runs, and its last minute. Maps its segments read-only, whoever comes and goes.
class LiveView final : public ViewSource {
 public:
  /// Begins to look. Throws std::runtime_error where it cannot save.
  explicit LiveView(const LiveOptions& options);

  [[nodiscard]] ViewStatus status() const override;
  [[nodiscard]] Message scene(std::optional<std::string_view> key) const override;
  [[nodiscard]] Message frame(std::optional<std::uint64_t> number) const override;
  [[nodiscard]] std::string ticks(std::uint64_t from, std::size_t most) const override;

 private:
  void run(const std::stop_token& stop);
  void capture();
  Frame look();
  void read_newest(Frame& frame, ToolLook& tool);
  void set_scene(Frame& frame, const ToolLook& tool);
  void learn_commands(const ToolLook& tool);
  void save(const std::string& key, const std::string& frame);
  [[nodiscard]] std::string note_of_absence() const;
  void tell(const Frame& frame, const ToolLook& tool);

  LiveOptions options_;
  TimeAxis real_axis_;
  ToolSampler sampler_;
  FrameStore frames_;

  // Of the thread.
  reading::SegmentFollower follower_;
  OtherHands others_;
  WriterCommand sim_command_, hand_command_;
  publication::SnapshotReader reader_;
  std::optional<reading::SceneSnapshot> snapshot_;  // the last that it accepted
  std::uint64_t next_frame_ = 1;
  std::unique_ptr<ViewWriter> writer_;
  std::uint64_t next_saved_tick_ = 0;
  std::optional<std::string> saved_key_;
  std::string told_;

  mutable std::mutex mutex_;
  std::deque<std::pair<std::string, Message>> scenes_;  // by key; first none, last the newest
  ViewStatus status_;
  std::jthread thread_;  // last: joined before what it uses is gone
};

}  // namespace stillgrid::scene_viewer

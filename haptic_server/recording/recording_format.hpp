#pragma once

#include <string>
#include <utility>
#include <vector>

#include "haptic_server/recording/scene_sample.hpp"
#include "haptic_server/recording/tick_row.hpp"

namespace stillgrid::recording {

/// What is told of the run as a whole, by key: scene, device, ...
using RecordingHead = std::vector<std::pair<std::string, std::string>>;

/// The form in which a file holds what is recorded. Its constructor adds the head. Thread: one at a
/// time.
class RecordingFormat {
 public:
  RecordingFormat() = default;
  virtual ~RecordingFormat() = default;
  RecordingFormat(const RecordingFormat&) = delete;
  RecordingFormat& operator=(const RecordingFormat&) = delete;
  RecordingFormat(RecordingFormat&&) = delete;
  RecordingFormat& operator=(RecordingFormat&&) = delete;

  /// Writes what stands beside the file. Throws std::runtime_error, one line, if it cannot.
  virtual void begin() {}

  virtual void add_row(const TickRow& row) = 0;

  /// Whether it holds scenes, and a sample of one.
  [[nodiscard]] virtual bool holds_scenes() const { return false; }
  virtual void add_scene(const SceneSample& /*scene*/) {}

  /// Adds what stands at the end.
  virtual void finish() {}
};

}  // namespace stillgrid::recording

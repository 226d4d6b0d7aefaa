#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "haptic_server/recording/mcap_writer.hpp"
#include "haptic_server/recording/recording_format.hpp"

namespace stillgrid::recording {

/// An MCAP file that Foxglove and PlotJuggler open: docs/formats.md, "MCAP".
class McapRecording : public RecordingFormat {
 public:
  /// clock_offset_ns: from the clock of rows and scenes to that of the messages.
  McapRecording(BlockFile& file, const RecordingHead& head, std::uint64_t clock_offset_ns);

  void add_row(const TickRow& row) override;
  [[nodiscard]] bool holds_scenes() const override { return true; }
  void add_scene(const SceneSample& scene) override;
  void finish() override { writer_.finish(); }

 private:
  McapWriter writer_;
  std::uint64_t clock_offset_ns_;
  std::uint16_t tick_, flags_, pose_, tool_, fixed_, moving_;  // channels
  std::optional<std::uint32_t> last_flags_;
  std::string json_;
};

}  // namespace stillgrid::recording

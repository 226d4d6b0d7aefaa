#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/tools/scene_viewer/tick_history.hpp"
#include "shared/tools/scene_viewer/view_source.hpp"

namespace stillgrid::scene_viewer {

/// A tick of a recording, as it is shown.
struct RecordedTick {
  TickSample sample;
  std::array<double, 3> velocity_m_s{};
  std::array<double, 4> orientation_xyzw = {0.0, 0.0, 0.0, 1.0};
  std::array<double, 3> torque_N_m{};
};

/// The rows of a recording (haptic_server --record, docs/formats.md): a time and a place each, and
/// what else is there. Throws std::runtime_error "FILE:LINE: column NAME: ...".
[[nodiscard]] std::vector<RecordedTick> read_recording(const std::filesystem::path& file);

/// A recording of haptic_server: the tool and what it felt, 30 frames a second; no bodies.
class RecordedView final : public ViewSource {
 public:
  /// Throws as read_recording().
  explicit RecordedView(const std::filesystem::path& file);

  [[nodiscard]] ViewStatus status() const override;
  [[nodiscard]] Message scene(std::optional<std::string_view> key) const override;
  [[nodiscard]] Message frame(std::optional<std::uint64_t> number) const override;
  [[nodiscard]] std::string ticks(std::uint64_t from, std::size_t most) const override;

 private:
  std::vector<RecordedTick> rows_;
  std::vector<TickSample> samples_;  // of the rows
  Message scene_;
  ViewStatus status_;
};

}  // namespace stillgrid::scene_viewer

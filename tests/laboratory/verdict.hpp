#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string_view>

#include "haptic_server/recording/recorder.hpp"

namespace stillgrid::laboratory {

/// What a closed loop comes to: metric 6 of the laboratory.
enum class Verdict {
  kStable,  // at rest but for the encoders' steps, and touching where it must
  kSwings,  // to and fro, and does not die away
  kParted,  // at rest, but what it should press is gone
  kNowhere  // no number, or out of the room
};
[[nodiscard]] std::string_view name_of(Verdict verdict) noexcept;

/// Encoder steps by which a loop at rest goes to and fro at most: four, however they were rounded.
inline constexpr double kQuietEncoderSteps = 4.001;

/// How a loop is judged, window by window.
struct VerdictRule {
  /// At least two cycles of the slowest mode that can swing, or that mode looks at rest.
  double window_s = 1.0;
  double limit_m = kQuietEncoderSteps * 30e-6;  // peak to peak along any axis
  double least_s = 20.0;                        // no verdict before
  double most_s = 60.0;                         // what still dies away then, swings
  bool must_touch = false;                      // in half of the last window's ticks
};

/// Judges a loop as it runs. It is at rest where it swings by no more than the limit over a window.
/// Where it swings by more but by a tenth less than a window before, it is given more time: a
/// transient is no swing, and no swing is stable for dying away by chance.
class VerdictWatch {
 public:
  explicit VerdictWatch(const VerdictRule& rule) : rule_(rule) {}

  /// Takes a tick; false once there is a verdict.
  bool take(const recording::TickRow& row);

  /// So far. What had no time for a verdict is judged by what there is: what dies away is stable.
  [[nodiscard]] Verdict verdict() const;

 private:
  struct Window {
    Eigen::Array3d lowest_m = Eigen::Array3d::Zero(), highest_m = lowest_m;
    std::uint64_t ticks = 0, touching = 0;

    void take(const recording::TickRow& row);
    [[nodiscard]] double swing_m() const { return (highest_m - lowest_m).maxCoeff(); }
    [[nodiscard]] bool touches() const { return 2 * touching >= ticks; }
  };
  [[nodiscard]] bool dies_away() const;

  VerdictRule rule_;
  Window window_;                // being filled
  Window last_;                  // the last that was full
  double swing_before_m_ = 0.0;  // of the full one before
  std::uint64_t windows_ = 0;    // that were full
  double window_end_s_ = 0.0;
  bool is_nowhere_ = false;
};

/// Of a run that is over.
[[nodiscard]] Verdict verdict_of(std::span<const recording::TickRow> rows,
                                 const VerdictRule& rule = {});

/// How far the tool still goes to and fro at the end of a run: peak to peak along the worst axis;
/// infinite where it is nowhere.
[[nodiscard]] double swing_m(std::span<const recording::TickRow> rows, double window_s);

}  // namespace stillgrid::laboratory

#pragma once

#include <span>
#include <vector>

namespace stillgrid::laboratory {

/// One-sided power spectral density.
struct Spectrum {
  double bin_hz = 0.0;                 // the distance of its bins, the first at 0 Hz
  std::vector<double> density_per_hz;  // in the signal's unit squared; empty: too short
};

/// Welch's estimate: means over segments of 1024 samples that overlap by half, each in a Hann
/// window. A sine of amplitude A adds A^2 / 2 to the power round its frequency [Welch 1967].
/// Empty for a signal shorter than a segment.
[[nodiscard]] Spectrum welch(std::span<const double> signal, double rate_hz);

/// The power between two frequencies, both included.
[[nodiscard]] double band_power(const Spectrum& spectrum, double low_hz, double high_hz);

}  // namespace stillgrid::laboratory

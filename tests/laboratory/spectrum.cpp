#include "tests/laboratory/spectrum.hpp"

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace stillgrid::laboratory {
namespace {

constexpr std::size_t kSegment = 1024;

std::vector<double> hann() {
  std::vector<double> window(kSegment);
  for (std::size_t i = 0; i < kSegment; ++i)
    window[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) /
                                     static_cast<double>(kSegment));
  return window;
}

}  // namespace

Spectrum welch(std::span<const double> signal, double rate_hz) {
  Spectrum spectrum{.bin_hz = rate_hz / static_cast<double>(kSegment), .density_per_hz = {}};
  if (signal.size() < kSegment) return spectrum;
  const std::vector<double> window = hann();
  constexpr double kWindowPower = 0.375 * static_cast<double>(kSegment);  // sum of its squares
  const std::size_t segments = (signal.size() - kSegment) / (kSegment / 2) + 1;
  const double per_segment = 1.0 / (rate_hz * kWindowPower * static_cast<double>(segments));

  spectrum.density_per_hz.assign(kSegment / 2 + 1, 0.0);
  Eigen::FFT<double> transform;
  std::vector<double> windowed(kSegment);
  std::vector<std::complex<double>> bins;
  for (std::size_t segment = 0; segment < segments; ++segment) {
    for (std::size_t i = 0; i < kSegment; ++i)
      windowed[i] = window[i] * signal[segment * (kSegment / 2) + i];
    transform.fwd(bins, windowed);
    for (std::size_t i = 0; i <= kSegment / 2; ++i) {
      const bool has_mirror = i != 0 && i != kSegment / 2;
      spectrum.density_per_hz[i] += (has_mirror ? 2.0 : 1.0) * std::norm(bins[i]) * per_segment;
    }
  }
  return spectrum;
}

double band_power(const Spectrum& spectrum, double low_hz, double high_hz) {
  double power = 0.0;
  for (std::size_t i = 0; i < spectrum.density_per_hz.size(); ++i) {
    const double frequency_hz = static_cast<double>(i) * spectrum.bin_hz;
    if (frequency_hz >= low_hz && frequency_hz <= high_hz)
      power += spectrum.density_per_hz[i] * spectrum.bin_hz;
  }
  return power;
}

}  // namespace stillgrid::laboratory

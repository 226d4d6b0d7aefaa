#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "tests/laboratory/fit_run/fit_reference.hpp"
#include "tests/test_folder.hpp"

namespace stillgrid::fit_run {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A trajectory that is at position_m(t) each millisecond.
inline std::string trajectory_text(double duration_s,
                                   const std::function<Eigen::Vector3d(double t_s)>& position_m) {
  std::string text = "time_s,x_m,y_m,z_m\n";
  for (int i = 0; i < std::lround(1e3 * duration_s); ++i) {
    const Eigen::Vector3d at_m = position_m(1e-3 * i);
    text += std::to_string(1e-3 * i);
    for (const double value : at_m) {
      std::array<char, 32> digits{};
      std::snprintf(digits.data(), digits.size(), ",%.17g", value);
      text += digits.data();
    }
    text += '\n';
  }
  return text;
}

}  // namespace stillgrid::fit_run

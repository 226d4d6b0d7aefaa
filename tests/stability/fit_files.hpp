#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include "tests/stability/fit_reference.hpp"

namespace stillgrid {

/// A folder for the files of one test, that goes with it.
class FitFolder {
 public:
  FitFolder() : path_(std::filesystem::temp_directory_path() / name()) {
    std::filesystem::create_directories(path_);
  }
  ~FitFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  FitFolder(const FitFolder&) = delete;
  FitFolder& operator=(const FitFolder&) = delete;

  std::filesystem::path write(const std::string& file, const std::string& text) const {
    std::ofstream(path_ / file, std::ios::binary) << text;
    return path_ / file;
  }
  [[nodiscard]] std::filesystem::path operator/(const std::string& file) const {
    return path_ / file;
  }

 private:
  static std::string name() {
    static int count = 0;
    return "stillgrid-fit-" + std::to_string(::getpid()) + "-" + std::to_string(++count);
  }
  std::filesystem::path path_;
};

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

}  // namespace stillgrid

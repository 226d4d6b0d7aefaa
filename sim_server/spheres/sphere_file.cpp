#include "sim_server/spheres/sphere_file.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "shared/files/text_file.hpp"
#include "shared/files/whole_file.hpp"

namespace stillgrid::spheres {
namespace {

constexpr const char* kHeader = "x_m,y_m,z_m,radius_m";

[[noreturn]] void refuse(const std::filesystem::path& file, int line, const std::string& what) {
  throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + what);
}

Ball parse_row(const std::string& text, const std::filesystem::path& file, int line) {
  static constexpr const char* kNames[] = {"x_m", "y_m", "z_m", "radius_m"};
  double values[4] = {};
  const char* at = text.c_str();
  for (int i = 0; i < 4; ++i) {
    char* end = nullptr;
    values[i] = std::strtod(at, &end);
    const bool ends_well = i < 3 ? *end == ',' : *end == '\0';
    if (end == at || !ends_well || !std::isfinite(values[i]))
      refuse(file, line,
             std::string(kNames[i]) + ": value '" + std::string(at, std::strcspn(at, ",")) +
                 "': expected a finite number, four in a row");
    at = end + 1;
  }
  if (!(values[3] > 0.0))
    refuse(file, line, "radius_m: value " + std::to_string(values[3]) + ": expected more than 0");
  return {{values[0], values[1], values[2]}, values[3]};
}

}  // namespace

std::vector<Ball> read_spheres(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMost = 256 * files::kMiB;
  std::istringstream in(files::read_text(file, kMost));
  std::vector<Ball> balls;
  bool has_header = false;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.empty() || text.front() == '#') continue;
    if (!has_header && text != kHeader)
      refuse(file, line, "header: value '" + text + "': expected " + kHeader);
    if (has_header) balls.push_back(parse_row(text, file, line));
    has_header = true;
  }
  if (balls.empty()) throw std::runtime_error(file.string() + ": 0 spheres: expected one at least");
  return balls;
}

void write_spheres(std::span<const Ball> balls, const std::filesystem::path& file,
                   std::string_view comment) {
  files::write_whole(file, [&](std::ostream& out) {
    out.precision(std::numeric_limits<double>::max_digits10);
    if (!comment.empty()) out << "# " << comment << '\n';
    out << kHeader << '\n';
    for (const Ball& ball : balls)
      out << ball.centre_m.x() << ',' << ball.centre_m.y() << ',' << ball.centre_m.z() << ','
          << ball.radius_m << '\n';
  });
}

}  // namespace stillgrid::spheres

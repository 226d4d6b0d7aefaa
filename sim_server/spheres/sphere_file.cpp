#include "sim_server/spheres/sphere_file.hpp"

#include <array>
#include <limits>
#include <ostream>
#include <string>

#include "shared/files/whole_file.hpp"
#include "shared/tables/number_table.hpp"

namespace stillgrid::spheres {
namespace {

constexpr const char* kHeader = "x_m,y_m,z_m,radius_m";
constexpr std::array<const char*, 4> kNames = {"x_m", "y_m", "z_m", "radius_m"};

}  // namespace

std::vector<Ball> read_spheres(const std::filesystem::path& file) {
  tables::NumberTable table(file, kHeader, tables::LastLine::kWhole);
  std::array<tables::Column, 4> columns;
  for (std::size_t i = 0; i < columns.size(); ++i)
    columns[i] = table.require({kNames[i]}, std::string(kHeader) + " (or _mm)");
  std::vector<Ball> balls;
  while (table.next()) {
    const double radius_m = table.length_m(columns[3]);
    if (!(radius_m > 0.0)) table.refuse_value(columns[3], "more than 0");
    balls.push_back(
        {{table.length_m(columns[0]), table.length_m(columns[1]), table.length_m(columns[2])},
         radius_m});
  }
  if (balls.empty()) table.refuse_file("0 spheres: expected one at least");
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

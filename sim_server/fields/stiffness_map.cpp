#include "sim_server/fields/stiffness_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "shared/files/number_text.hpp"
#include "shared/files/text_file.hpp"
#include "sim_server/spheres/ball_tree.hpp"

namespace stillgrid::fields {
namespace {

using Eigen::Vector3d;

constexpr std::string_view kHeader = "x_m,y_m,z_m,stiffness_N_per_m";
constexpr std::array<std::string_view, 4> kColumns = {"x_m", "y_m", "z_m", "stiffness_N_per_m"};
constexpr double kLargest = 1e12, kLeast = 1e-9;
constexpr std::size_t kNeighbours = 3;

[[noreturn]] void refuse(const std::filesystem::path& file, int line, std::string_view column,
                         std::string_view value, std::string_view expected) {
  throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + std::string(column) +
                           ": value '" + std::string(value.substr(0, 40)) + "': expected " +
                           std::string(expected));
}

StiffnessPlace parse_row(std::string_view row, const std::filesystem::path& file, int line) {
  if (std::ranges::count(row, ',') != 3) refuse(file, line, "row", row, "four numbers");
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < 4; ++i) {
    std::string_view field = row.substr(0, row.find(','));
    row.remove_prefix(std::min(row.size(), field.size() + 1));
    while (field.starts_with(' ')) field.remove_prefix(1);
    while (field.ends_with(' ')) field.remove_suffix(1);
    const std::optional<double> value = files::finite_number(field);
    if (i < 3 && !(value && std::abs(*value) <= kLargest))
      refuse(file, line, kColumns[i], field, "a number from -1e12 to 1e12");
    if (i == 3 && !(value && *value >= kLeast && *value <= kLargest))
      refuse(file, line, kColumns[i], field, "a number from 1e-9 to 1e12");
    values[i] = *value;
  }
  return {{values[0], values[1], values[2]}, values[3]};
}

/// The mean distance to the nearest places elsewhere; 0 where there is none. Looked for within
/// first_m, then farther.
double spacing_m(const spheres::BallTree& tree, std::span<const spheres::Ball> centres,
                 const Vector3d& place_m, double first_m, double farthest_m) {
  for (double within_m = first_m;; within_m *= 2.0) {
    std::vector<double> distances_m;
    for (const std::uint32_t i : tree.balls_within(place_m, within_m)) {
      const double distance_m = (centres[i].centre_m - place_m).norm();
      if (distance_m > 0.0) distances_m.push_back(distance_m);
    }
    if (distances_m.size() < kNeighbours && within_m < farthest_m) continue;
    std::ranges::sort(distances_m);
    distances_m.resize(std::min(distances_m.size(), kNeighbours));
    double sum_m = 0.0;
    for (const double distance_m : distances_m) sum_m += distance_m;
    return distances_m.empty() ? 0.0 : sum_m / static_cast<double>(distances_m.size());
  }
}

}  // namespace

std::vector<StiffnessPlace> read_stiffness_places(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMost = 64 * files::kMiB;
  std::istringstream in(files::read_text(file, kMost));
  std::vector<StiffnessPlace> places;
  bool has_header = false;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.empty() || text.front() == '#') continue;
    if (!has_header && text != kHeader) refuse(file, line, "header", text, kHeader);
    if (has_header) places.push_back(parse_row(text, file, line));
    has_header = true;
    if (places.size() > kMaxStiffnessPlaces)
      throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": expected at most " +
                               std::to_string(kMaxStiffnessPlaces) + " places");
  }
  if (places.empty()) throw std::runtime_error(file.string() + ": 0 places: expected one at least");
  return places;
}

StiffnessMap::StiffnessMap(std::span<const StiffnessPlace> places, double own_N_per_m)
    : places_(places.begin(), places.end()), own_N_per_m_(own_N_per_m) {
  if (places_.empty()) return;
  std::vector<spheres::Ball> centres;
  Eigen::AlignedBox3d box;
  for (const StiffnessPlace& place : places_) {
    centres.push_back({place.position_m, 0.0});
    box.extend(place.position_m);
  }
  const double farthest_m = box.diagonal().norm();
  if (farthest_m == 0.0) return;
  // About a spacing of places that lie evenly in a plane.
  const double first_m = farthest_m / std::sqrt(static_cast<double>(places_.size()));
  const spheres::BallTree tree(centres);
  for (const spheres::Ball& centre : centres)
    balls_.push_back(
        {centre.centre_m, kWidth * spacing_m(tree, centres, centre.centre_m, first_m, farthest_m)});
  grid_ = spheres::make_ball_grid(balls_, 0.0);
}

double StiffnessMap::stiffness_N_per_m(const Vector3d& point_m) const {
  if (places_.empty()) return own_N_per_m_;
  if (balls_.empty()) {
    double sum_N_per_m = 0.0;
    for (const StiffnessPlace& place : places_) sum_N_per_m += place.stiffness_N_per_m;
    return sum_N_per_m / static_cast<double>(places_.size());
  }
  double weights = kOwnWeight, sum_N_per_m = kOwnWeight * own_N_per_m_;
  for (const std::uint32_t i : spheres::balls_near(grid_, point_m)) {
    const double share =
        (point_m - balls_[i].centre_m).squaredNorm() / (balls_[i].radius_m * balls_[i].radius_m);
    if (share >= 1.0) continue;
    const double weight = (1.0 - share) * (1.0 - share) * (1.0 - share);
    weights += weight;
    sum_N_per_m += weight * places_[i].stiffness_N_per_m;
  }
  return weights == kOwnWeight ? own_N_per_m_ : sum_N_per_m / weights;
}

}  // namespace stillgrid::fields

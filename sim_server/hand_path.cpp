#include "sim_server/hand_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "shared/files/number_text.hpp"
#include "shared/files/text_file.hpp"

namespace stillgrid::sim_server {
namespace {

constexpr std::array<std::string_view, 8> kColumns = {"time_s", "x_m", "y_m", "z_m",
                                                      "qx",     "qy",  "qz",  "qw"};
constexpr std::size_t kRequired = 4;
constexpr double kLongest_m = 1e6;  // from zero: what no hand reaches is somebody's slip
constexpr std::uintmax_t kMostBytes = 1024 * files::kMiB;
constexpr double kNormTolerance = 0.05;  // of orientations: recordings round to a few digits

using Fields = std::vector<std::string_view>;

Fields split(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  Fields fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    std::string_view field = line.substr(begin, end - begin);
    field.remove_prefix(std::min(field.find_first_not_of(kBlank), field.size()));
    fields.push_back(field.substr(0, field.find_last_not_of(kBlank) + 1));
    begin = end + 1;
  }
  return fields;
}

/// The lines of a file, one at a time, and refusals that name them.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& file)
      : file_(file.string()), stream_(files::read_text(file, kMostBytes)) {}

  /// The next line with anything in it; comments are left out.
  std::optional<Fields> next() {
    while (std::getline(stream_, text_)) {
      ++line_;
      if (line_ == 1 && text_.starts_with("\xEF\xBB\xBF"))
        refuse(kColumns[0], "a byte-order mark before it: expected none");
      if (text_.starts_with("# scene: ") || text_.find(",rendered_fx_N,") != std::string::npos)
        refuse("file",
               "a recording of haptic_server, which is in the scene's frame: expected the "
               "path of a device");
      if (text_.starts_with('#') || text_.find_first_not_of(" \t\r") == std::string::npos) continue;
      return split(text_);
    }
    return std::nullopt;
  }

  [[noreturn]] void refuse(std::string_view column, const std::string& fault) const {
    throw std::runtime_error(file_ + ":" + std::to_string(line_) + ": column " +
                             std::string(column) + ": " + fault);
  }

  [[nodiscard]] double number(const Fields& fields, std::size_t at, std::string_view column) const {
    const auto value = at < fields.size() ? files::finite_number(fields[at]) : std::nullopt;
    if (!value || std::abs(*value) > kLongest_m) refuse(column, "expected a number up to 1e6");
    return *value;
  }

 private:
  std::string file_, text_;
  std::istringstream stream_;
  int line_ = 0;
};

/// Where each of kColumns stands; the orientation's may be missing, all together.
std::vector<std::size_t> places_of(const Fields& header, const Lines& lines) {
  std::vector<std::size_t> places;
  for (const std::string_view column : kColumns) {
    const auto found = std::find(header.begin(), header.end(), column);
    if (std::count(header.begin(), header.end(), column) > 1)
      lines.refuse(column, "given twice: expected it once");
    if (found != header.end())
      places.push_back(static_cast<std::size_t>(found - header.begin()));
    else if (places.size() != kRequired)
      lines.refuse(column, "missing: expected time_s,x_m,y_m,z_m, or with qx,qy,qz,qw");
  }
  if (places.size() != kRequired && places.size() != kColumns.size())
    lines.refuse("qx", "missing: expected qx,qy,qz,qw, or none of them");
  return places;
}

}  // namespace

HandPath::HandPath(const std::filesystem::path& file, const scene::DeviceFrame& device) {
  Lines lines(file);
  const std::optional<Fields> header = lines.next();
  if (!header) lines.refuse(kColumns[0], "missing: expected a header");
  const std::vector<std::size_t> places = places_of(*header, lines);
  const std::size_t columns = header->size();
  double first_s = 0.0;
  while (const std::optional<Fields> fields = lines.next()) {
    if (fields->size() > columns)
      lines.refuse(std::to_string(columns + 1), "not in the header: expected " +
                                                    std::to_string(columns) + " fields, found " +
                                                    std::to_string(fields->size()));
    std::array<double, kColumns.size()> values{0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    for (std::size_t i = 0; i < places.size(); ++i)
      values[i] = lines.number(*fields, places[i], kColumns[i]);
    if (time_s_.empty()) first_s = values[0];
    const double time_s = values[0] - first_s;
    if (!time_s_.empty() && !(time_s > time_s_.back()))
      lines.refuse("time_s", "expected a time after that of the row above");
    const Eigen::Quaterniond turn(values[7], values[4], values[5], values[6]);
    if (!(std::abs(turn.norm() - 1.0) < kNormTolerance))
      lines.refuse("qw", "expected a quaternion of norm one");
    const Eigen::Vector3d position_m(values[1], values[2], values[3]);
    time_s_.push_back(time_s);
    poses_.push_back({device.position_m + device.scale * (device.orientation * position_m),
                      places.size() > kRequired
                          ? (device.orientation * turn.normalized()).normalized()
                          : Eigen::Quaterniond::Identity()});
  }
  if (time_s_.size() < 2) lines.refuse("time_s", "expected two rows at least");
}

HandPose HandPath::at(double time_s) const noexcept {
  const auto after = std::upper_bound(time_s_.begin(), time_s_.end(), time_s);
  if (after == time_s_.begin()) return poses_.front();
  if (after == time_s_.end()) return poses_.back();
  const auto i = static_cast<std::size_t>(after - time_s_.begin());
  const double share = (time_s - time_s_[i - 1]) / (time_s_[i] - time_s_[i - 1]);
  const HandPose &from = poses_[i - 1], &to = poses_[i];
  return {from.position_m + share * (to.position_m - from.position_m),
          from.orientation.slerp(share, to.orientation)};
}

}  // namespace stillgrid::sim_server

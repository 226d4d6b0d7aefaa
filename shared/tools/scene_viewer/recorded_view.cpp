#include "shared/tools/scene_viewer/recorded_view.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "shared/files/number_text.hpp"
#include "shared/files/old_names.hpp"
#include "shared/files/text_file.hpp"
#include "shared/tools/scene_viewer/frame.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr double kFramesPerSecond = 30.0;
constexpr std::uintmax_t kMostBytes = 1024 * files::kMiB;
constexpr double kLatest_s = 1e9;  // of a row; 30 years, in which nanoseconds can be counted

/// Text at the separators, which are left out.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// What is wrong with a value, or nothing.
using Take = std::function<std::string(std::string_view, RecordedTick&)>;

template <class Store>
Take number_to(Store&& store) {
  return [store](std::string_view text, RecordedTick& tick) -> std::string {
    const auto value = files::finite_number(text);
    if (!value) return "expected a number";
    store(tick, *value);
    return {};
  };
}

std::string take_flags(std::string_view text, RecordedTick& tick) {
  if (text.empty()) return {};
  for (const std::string_view written : split(text, '|')) {
    const std::string_view name = files::name_of_today(files::kOldFlags, written);
    const auto* const found =
        std::find(proto::kSafetyFlagNames.begin(), proto::kSafetyFlagNames.end(), name);
    if (found == proto::kSafetyFlagNames.end()) return "expected names of flags, joined by |";
    tick.sample.flags |= 1U << (found - proto::kSafetyFlagNames.begin());
  }
  return {};
}

/// Three or four columns of an array.
template <class Array>
void add_columns(std::vector<std::pair<std::string_view, Take>>& columns,
                 std::initializer_list<std::string_view> names, Array array) {
  std::size_t i = 0;
  for (const std::string_view name : names)
    columns.emplace_back(name, number_to([array, axis = i++](RecordedTick& tick, double value) {
                           array(tick)[axis] = value;
                         }));
}

/// Not below zero, as all that is counted.
std::uint64_t count_of(double value) {
  return value > 0.0 && value < 1e18 ? static_cast<std::uint64_t>(value) : 0;
}

std::vector<std::pair<std::string_view, Take>> known_columns() {
  std::vector<std::pair<std::string_view, Take>> columns;
  const auto add = [&](std::string_view name, auto&& store) {
    columns.emplace_back(name, number_to(store));
  };
  add("time_s", [](RecordedTick& tick, double value) { tick.sample.time_s = value; });
  add_columns(
      columns, {"x_m", "y_m", "z_m"},
      [](RecordedTick & tick) -> auto& { return tick.sample.position_m; });
  add_columns(
      columns, {"vx_m_s", "vy_m_s", "vz_m_s"},
      [](RecordedTick & tick) -> auto& { return tick.velocity_m_s; });
  add_columns(
      columns, {"fx_N", "fy_N", "fz_N"},
      [](RecordedTick & tick) -> auto& { return tick.sample.force_N; });
  add_columns(
      columns, {"tx_N_m", "ty_N_m", "tz_N_m"},
      [](RecordedTick & tick) -> auto& { return tick.torque_N_m; });
  add_columns(
      columns, {"qx", "qy", "qz", "qw"},
      [](RecordedTick & tick) -> auto& { return tick.orientation_xyzw; });
  add("snapshot_id",
      [](RecordedTick& tick, double value) { tick.sample.snapshot_id = count_of(value); });
  add("contacts", [](RecordedTick& tick, double value) {
    tick.sample.contacts = static_cast<std::uint32_t>(std::clamp(value, 0.0, 1e9));
  });
  add("age_s", [](RecordedTick& tick, double value) { tick.sample.age_s = value; });
  add("tick_ns", [](RecordedTick& tick, double value) { tick.sample.work_us = value * 1e-3; });
  columns.emplace_back("flags", take_flags);
  return columns;
}

constexpr std::size_t kNeeded = 4;  // of the known columns: time and place

/// Takes a recording's lines, the first as the names of its columns.
class RecordingReader {
 public:
  /// What is wrong with a line, or nothing: then it is one of the rows.
  std::string take(std::string_view line, std::vector<RecordedTick>& rows) {
    const auto fields = split(line, ',');
    if (takes_.empty()) return take_names(fields);
    if (fields.size() != takes_.size())
      return "value " + std::to_string(fields.size()) + " columns: expected " +
             std::to_string(takes_.size());
    RecordedTick tick;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (takes_[i] == nullptr) continue;
      std::string fault = (*takes_[i])(fields[i], tick);
      const double time_s = tick.sample.time_s;
      if (i == time_column_ && fault.empty()) {
        if (!(time_s >= 0.0 && time_s <= kLatest_s)) fault = "expected seconds from 0 to 1e9";
        if (!rows.empty() && !(time_s > rows.back().sample.time_s))
          fault = "expected times that grow";
      }
      if (!fault.empty())
        return "column " + names_[i] + ": value '" + std::string(fields[i]) + "': " + fault;
    }
    tick.sample.tick = rows.size() + 1;
    rows.push_back(tick);
    return {};
  }

 private:
  std::string take_names(std::vector<std::string_view> names) {
    for (std::string_view& name : names) name = files::name_of_today(files::kOldColumns, name);
    names_.assign(names.begin(), names.end());
    for (std::size_t i = 0; i < kNeeded; ++i)
      if (std::count(names.begin(), names.end(), known_[i].first) != 1)
        return "column " + std::string(known_[i].first) + ": expected once";
    for (const auto& [name, take] : known_)
      if (std::count(names.begin(), names.end(), name) > 1)
        return "column " + std::string(name) + ": given twice, by this name or an earlier one";
    for (const std::string_view name : names) {
      const auto found = std::find_if(known_.begin(), known_.end(),
                                      [&](const auto& column) { return column.first == name; });
      takes_.push_back(found == known_.end() ? nullptr : &found->second);
      if (name == "time_s") time_column_ = takes_.size() - 1;
    }
    return {};
  }

  const std::vector<std::pair<std::string_view, Take>> known_ = known_columns();
  std::vector<const Take*> takes_;  // by column of the file; null: not shown
  std::vector<std::string> names_;
  std::size_t time_column_ = 0;
};

/// Frames of rows at that spacing.
std::uint64_t frame_count(const std::vector<RecordedTick>& rows) {
  const double length_s = rows.back().sample.time_s - rows.front().sample.time_s;
  return static_cast<std::uint64_t>(length_s * kFramesPerSecond) + 1;
}

}  // namespace

std::vector<RecordedTick> read_recording(const std::filesystem::path& file) {
  std::istringstream in(files::read_text(file, kMostBytes));
  RecordingReader reader;
  std::vector<RecordedTick> rows;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    const std::string fault = reader.take(line, rows);
    if (fault.empty()) continue;
    if (in.eof() && !rows.empty()) break;  // a line that was cut off
    throw std::runtime_error(file.string() + ":" + std::to_string(number) + ": " + fault);
  }
  if (rows.empty())
    throw std::runtime_error("--recording: " + file.string() + ": expected a row at least");
  return rows;
}

RecordedView::RecordedView(const std::filesystem::path& file) : rows_(read_recording(file)) {
  for (const RecordedTick& row : rows_) samples_.push_back(row.sample);
  const std::string key = "recording";
  scene_ = std::make_shared<const std::string>(
      empty_scene_message(ViewKind::kRecording, file.filename().string(), key));
  status_ = {.live = false,
             .first_frame = 1,
             .last_frame = frame_count(rows_),
             .sim = reading::Life::kAbsent,
             .hand = reading::Life::kAbsent,
             .now_s = rows_.back().sample.time_s,
             .scene_key = key,
             .note = "",
             .sim_command = "",
             .hand_command = ""};
}

ViewStatus RecordedView::status() const {
  return status_;
}

Message RecordedView::scene(std::optional<std::string_view> key) const {
  return !key || *key == status_.scene_key ? scene_ : nullptr;
}

Message RecordedView::frame(std::optional<std::uint64_t> number) const {
  const std::uint64_t wanted = number.value_or(status_.last_frame);
  if (wanted == 0 || wanted > status_.last_frame) return nullptr;
  const double time_s =
      rows_.front().sample.time_s + static_cast<double>(wanted - 1) / kFramesPerSecond;
  const auto after = std::upper_bound(
      rows_.begin(), rows_.end(), time_s,
      [](double at_s, const RecordedTick& row) { return at_s < row.sample.time_s; });
  const RecordedTick& row = *(after - (after == rows_.begin() ? 0 : 1));
  Frame frame;
  frame.number = wanted;
  frame.now_ns = static_cast<std::uint64_t>(std::llround(std::max(0.0, time_s) * 1e9));
  frame.scene_key = status_.scene_key;
  proto::ToolState& state = frame.tool.emplace();
  state.time_ns = frame.now_ns;
  state.tick = row.sample.tick;
  state.position_m = row.sample.position_m;
  state.orientation_xyzw = row.orientation_xyzw;
  state.velocity_m_s = row.velocity_m_s;
  state.force_N = row.sample.force_N;
  state.before.torque_N_m = row.torque_N_m;
  state.before.contacts = row.sample.contacts;
  state.before.flags = row.sample.flags;
  state.before.displayed.snapshot_id = row.sample.snapshot_id;
  state.before.displayed.age_s = row.sample.age_s;
  frame.ticks = summary_of(std::span(samples_).first(row.sample.tick));
  return std::make_shared<const std::string>(frame_message(frame));
}

std::string RecordedView::ticks(std::uint64_t from, std::size_t most) const {
  return tick_message(ticks_from(samples_, from, most));
}

}  // namespace stillgrid::scene_viewer

#include "shared/tools/scene_viewer/recorded_view.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/tables/number_table.hpp"
#include "shared/tools/scene_viewer/frame.hpp"
#include "shared/tools/scene_viewer/scene_message.hpp"

namespace stillgrid::scene_viewer {
namespace {

constexpr double kFramesPerSecond = 30.0;
constexpr double kLatest_s = 1e9;  // of a row; 30 years, in which nanoseconds can be counted

/// A column that is shown, and where its number goes.
struct ShownColumn {
  std::string name;
  std::function<void(RecordedTick&, double)> store;
};

/// Three or four columns of an array.
template <class Array>
void add_columns(std::vector<ShownColumn>& columns, std::initializer_list<std::string> names,
                 Array array) {
  std::size_t i = 0;
  for (const std::string& name : names)
    columns.push_back({name, [array, axis = i++](RecordedTick& tick, double value) {
                         array(tick)[axis] = value;
                       }});
}

/// Not below zero, as all that is counted.
std::uint64_t count_of(double value) {
  return value > 0.0 && value < 1e18 ? static_cast<std::uint64_t>(value) : 0;
}

std::vector<ShownColumn> known_columns() {
  std::vector<ShownColumn> columns;
  const auto add = [&](const char* name, auto&& store) { columns.push_back({name, store}); };
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
  return columns;
}

std::uint32_t flags_of(const tables::NumberTable& table, const tables::Column& column) {
  std::uint32_t flags = 0;
  if (table.text(column).empty()) return flags;
  for (const std::string_view name : tables::split(table.text(column), '|')) {
    const auto* const found =
        std::find(proto::kSafetyFlagNames.begin(), proto::kSafetyFlagNames.end(), name);
    if (found == proto::kSafetyFlagNames.end())
      table.refuse_value(column, "names of flags, joined by |");
    flags |= 1U << (found - proto::kSafetyFlagNames.begin());
  }
  return flags;
}

/// Frames of rows at that spacing.
std::uint64_t frame_count(const std::vector<RecordedTick>& rows) {
  const double length_s = rows.back().sample.time_s - rows.front().sample.time_s;
  return static_cast<std::uint64_t>(length_s * kFramesPerSecond) + 1;
}

}  // namespace

std::vector<RecordedTick> read_recording(const std::filesystem::path& file) {
  const std::string needed = "time_s, x_m, y_m, z_m";
  tables::NumberTable table(file, needed, tables::LastLine::kMayBeCut);
  const tables::Column time = table.require({"time_s", "t_s"}, needed);
  const std::array<tables::Column, 3> place = {table.require({"x_m"}, needed),
                                               table.require({"y_m"}, needed),
                                               table.require({"z_m"}, needed)};
  const auto flags = table.find({"flags"});
  std::vector<std::pair<tables::Column, const ShownColumn*>> shown;
  const std::vector<ShownColumn> known = known_columns();
  for (const ShownColumn& column : known)
    if (const auto found = table.find({column.name})) shown.emplace_back(*found, &column);
  std::vector<RecordedTick> rows;
  while (table.next()) {
    RecordedTick tick;
    tick.sample.time_s = table.number(time);
    if (!(tick.sample.time_s >= 0.0 && tick.sample.time_s <= kLatest_s))
      table.refuse_value(time, "seconds from 0 to 1e9");
    if (!rows.empty() && !(tick.sample.time_s > rows.back().sample.time_s))
      table.refuse_value(time, "times that grow");
    for (std::size_t axis = 0; axis < 3; ++axis)
      tick.sample.position_m[axis] = table.length_m(place[axis]);
    for (const auto& [column, of] : shown) of->store(tick, table.number(column));
    if (flags) tick.sample.flags = flags_of(table, *flags);
    tick.sample.tick = rows.size() + 1;
    rows.push_back(tick);
  }
  if (rows.empty()) table.refuse_file("expected a row at least");
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

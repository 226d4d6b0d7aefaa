#include "haptic_server/recording/csv_recording.hpp"

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "shared/files/json_file.hpp"
#include "shared/files/whole_file.hpp"

namespace stillgrid::recording {
namespace {

constexpr const char* kColumns =
    "time_s,x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,fx_N,fy_N,fz_N,rendered_fx_N,rendered_fy_N,"
    "rendered_fz_N,snapshot_id,alpha,contacts,age_s,tick_ns,flags,tx_N_m,ty_N_m,tz_N_m,"
    "qx,qy,qz,qw\n";

template <class Number>
void append(std::string& line, Number value) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  line.append(text.data(), end);
  line += ',';
}

void append(std::string& line, const Eigen::Vector3d& v) {
  append(line, v.x());
  append(line, v.y());
  append(line, v.z());
}

}  // namespace

void append_row(const TickRow& row, std::string& line) {
  append(line, row.time_s);
  append(line, row.position_m);
  append(line, row.velocity_m_s);
  append(line, row.force_N);
  append(line, row.rendered_N);
  append(line, row.snapshot_id);
  append(line, row.alpha);
  append(line, row.contacts);
  append(line, row.age_s);
  append(line, row.tick_ns);
  append_flags(row.flags, line);
  line += ',';
  append(line, row.torque_N_m);
  for (const double number : row.orientation.coeffs()) append(line, number);
  line.pop_back();
}

std::filesystem::path metadata_file(const std::filesystem::path& csv) {
  return csv.string() + "-metadata.json";
}

CsvRecording::CsvRecording(BlockFile& file, const std::filesystem::path& path,
                           const RecordingHead& head)
    : file_(file), path_(path) {
  file_.add(kColumns, 0);
  if (!std::filesystem::is_regular_file(path)) return;
  head_ = head;
  try {
    files::require_writable(metadata_file(path));
  } catch (const std::exception& error) {
    throw std::runtime_error(std::string("--record: ") + error.what());
  }
}

void CsvRecording::begin() {
  if (head_.empty()) return;
  nlohmann::ordered_json notes;
  for (const auto& [key, value] : head_) notes[key] = value;
  files::write_json(metadata_file(path_), {{"@context", "http://www.w3.org/ns/csvw"},
                                           {"url", path_.filename().string()},
                                           {"notes", nlohmann::ordered_json::array({notes})}});
}

void CsvRecording::add_row(const TickRow& row) {
  line_.clear();
  append_row(row, line_);
  line_ += '\n';
  file_.add(line_, 1);
}

}  // namespace stillgrid::recording

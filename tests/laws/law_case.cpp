#include "tests/laws/law_case.hpp"

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/path_file.hpp"
#include "tests/laws/random.hpp"

namespace stillgrid::laws {
namespace {

double number_of(const std::string& key, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0')
    throw std::runtime_error("# " + key + ": '" + text + "': expected a number");
  return value;
}

/// Reads "# key: value"; a comment of another form is prose.
void read_head(const std::string& line, LawCase& law_case) {
  const auto colon = line.find(": ");
  if (colon == std::string::npos) return;
  const std::string key = line.substr(2, colon - 2), value = line.substr(colon + 2);
  const std::map<std::string, std::function<void()>> keys = {
      {"law", [&] { law_case.law = static_cast<int>(number_of(key, value)); }},
      {"seed", [&] { law_case.seed = std::strtoull(value.c_str(), nullptr, 10); }},
      {"hand", [&] { law_case.hand = hand_of(value); }},
      {"other_hand", [&] { law_case.other_hand = hand_of(value); }},
      {"device", [&] { law_case.device = value; }},
      {"transition", [&] { law_case.transition = value; }},
      {"model", [&] { law_case.model = value; }},
      {"latency_share", [&] { law_case.latency_share = number_of(key, value); }},
      {"jitter", [&] { law_case.jitter = number_of(key, value); }},
      {"duration_s", [&] { law_case.duration_s = number_of(key, value); }},
      {"repeat", [&] { law_case.repeat = static_cast<int>(number_of(key, value)); }},
      {"variant", [&] { law_case.variant = value; }},
      {"until", [&] { law_case.until = value; }}};
  const auto found = keys.find(key);
  if (found != keys.end()) found->second();
}

std::filesystem::path data_folder() {
  const char* given = std::getenv("STILLGRID_DATA");
  return given != nullptr ? std::filesystem::path(given)
                          : std::filesystem::path(STILLGRID_SOURCE_DIR) / "../shared/data";
}

std::string with_data(const std::string& device) {
  const std::string mark = "$DATA";
  const auto at = device.find(mark);
  if (at == std::string::npos) return device;
  const auto file_end = device.find(',', at);
  const std::string file =
      data_folder().string() + device.substr(at + mark.size(), file_end - at - mark.size());
  if (!std::filesystem::exists(file)) throw NoData(file + " is not here");
  return device.substr(0, at) + file +
         (file_end == std::string::npos ? "" : device.substr(file_end));
}

std::shared_ptr<laboratory::PathFile> path_of(const LawCase& law_case,
                                              const scene::SceneDescription& scene, double tick_s) {
  std::vector<laboratory::PathPoint> points;
  const auto ticks = static_cast<int>(law_case.duration_s / tick_s) + 2;
  Random random(law_case.seed);
  const double noise_m = law_case.hand->noise_m;
  const auto step_m = [&] { return noise_m > 0.0 ? random.between(-noise_m, noise_m) : 0.0; };
  for (int tick = 0; tick < ticks; ++tick) {
    const Eigen::Vector3d at_m = motion_at(*law_case.hand, tick * tick_s).position_m;
    points.push_back({tick * tick_s, at_m + Eigen::Vector3d(step_m(), step_m(), step_m())});
  }
  return std::make_shared<laboratory::PathFile>(scene.device, points);
}

}  // namespace

std::string print_case(const LawCase& law_case) {
  std::string text = "# law: " + std::to_string(law_case.law) + "\n";
  const auto add = [&text](const char* key, const std::string& value) {
    text += std::string("# ") + key + ": " + value + "\n";
  };
  if (!law_case.until.empty()) add("until", law_case.until);
  if (law_case.hand) add("hand", text_of(*law_case.hand));
  if (law_case.other_hand) add("other_hand", text_of(*law_case.other_hand));
  if (!law_case.device.empty()) add("device", law_case.device);
  if (law_case.transition != "local") add("transition", law_case.transition);
  if (law_case.model != "grid") add("model", law_case.model);
  if (!law_case.variant.empty()) add("variant", law_case.variant);
  if (law_case.repeat != 0) add("repeat", std::to_string(law_case.repeat));
  if (law_case.latency_share != 0.0) add("latency_share", short_number(law_case.latency_share));
  if (law_case.jitter != 0.0) add("jitter", short_number(law_case.jitter));
  if (law_case.seed != 1) add("seed", std::to_string(law_case.seed));
  add("duration_s", short_number(law_case.duration_s));
  return text + law_case.scene.print();
}

LawCase parse_case(const std::string& text) {
  LawCase law_case;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("# ")) read_head(line, law_case);
  law_case.scene = parse_scene_text(text);
  if (law_case.law < 1 || law_case.law > 18)
    throw std::runtime_error("# law: " + std::to_string(law_case.law) +
                             ": expected a line '# law: N', N from 1 to 18");
  return law_case;
}

LawCase load_case(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream.is_open()) throw std::runtime_error(file.string() + ": expected a file to read");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  try {
    return parse_case(text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

std::filesystem::path scene_folder() {
  return std::filesystem::path(STILLGRID_SOURCE_DIR) / "sim_server/scene/scenes";
}

scene::SceneDescription scene_of(const LawCase& law_case) {
  return scene::read_scene(law_case.scene.print(), scene_folder() / "case.toml");
}

CaseLoop loop_of(const LawCase& law_case, const scene::SceneDescription& scene) {
  CaseLoop loop;
  laboratory::LabOptions& options = loop.options;
  const auto transition = display::transition_named(law_case.transition);
  if (!transition) throw std::runtime_error("# transition: '" + law_case.transition + "': unknown");
  options.rival = laboratory::rival_named(law_case.model);
  if (options.rival == nullptr && law_case.model != "grid")
    throw std::runtime_error("# model: '" + law_case.model + "': unknown");
  options.transition = *transition;
  options.latency_s = law_case.latency_share * scene.period_s;
  options.jitter = law_case.jitter;
  options.seed = law_case.seed;
  options.duration_s = law_case.duration_s;
  if (law_case.hand) {
    auto path = path_of(law_case, scene, 1.0 / options.tick_rate_hz);
    options.device = "replay:file=" + path->path().string();
    loop.path = std::move(path);
  } else {
    options.device = with_data(law_case.device);
  }
  return loop;
}

}  // namespace stillgrid::laws

#include "sim_server/method_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "shared/files/json_file.hpp"
#include "shared/files/text_file.hpp"

namespace stillgrid::sim_server {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;
constexpr int kMaxSubsteps = 10000;

/// FNV-1a of a scene file's bytes, of its hand's where a rate is chosen for that, of the spheres
/// and nodes that its meshes were made into, and of maps of stiffness, as hexadecimal digits.
std::string hash_of(const std::filesystem::path& file, const scene::SceneDescription& scene) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](char byte) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  };
  const auto add_file = [&](const std::filesystem::path& one) {
    for (const char byte : files::read_text(one, 1024 * files::kMiB)) add(byte);
  };
  add_file(file);
  if (scene.choose_rate) add_file(scene.hand->file);
  for (const bodies::BodyDescription& body : scene.bodies) {
    for (const spheres::Ball& ball : bodies::balls_of(body)) {
      std::array<char, 100> text{};  // not the bits: another machine's last digit is another
      std::snprintf(text.data(), text.size(), "%.5g %.5g %.5g %.5g", ball.centre_m.x(),
                    ball.centre_m.y(), ball.centre_m.z(), ball.radius_m);
      for (const char byte : std::string_view(text.data())) add(byte);
    }
    if (const auto field = bodies::field_of(body))
      for (const char byte : std::to_string(field->shape().fine_count)) add(byte);
    if (const auto* const mesh = std::get_if<bodies::RigidMeshBody>(&body.shape);
        mesh != nullptr && mesh->asked_field)
      for (const fields::StiffnessPlace& place : mesh->asked_field->measured.places)
        for (const char byte : std::to_string(place.stiffness_N_per_m)) add(byte);
    const bodies::SoftLattice* lattice = bodies::lattice_of(body);
    const std::size_t nodes = lattice != nullptr ? lattice->nodes_m.size() : 0;
    for (const char byte : std::to_string(nodes)) add(byte);
  }
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
  return digits.data();
}

Json json_of(const scene::Method& method) {
  return {{"integrator", scene::name_of(method.integrator)},
          {"solver", scene::name_of(method.solver)},
          {"substeps", method.substeps},
          {"tolerance_m_s", method.tolerance_m_s}};
}

Json json_of(const dynamics::MethodTrial& trial) {
  Json json = json_of(trial.method);
  const auto add = [&](const char* key, const std::optional<double>& value) {
    if (value && std::isfinite(*value)) json[key] = *value;
  };
  add("predicted_ms", trial.predicted_ms);
  add("measured_ms", trial.measured_ms);
  add("slow_ms", trial.slow_ms);
  add("error_m", trial.error_m);
  if (!trial.refusal.empty()) json["refusal"] = trial.refusal;
  return json;
}

Json json_of(const RateTrial& trial) {
  Json json = {{"rate_hz", trial.rate_hz}, {"runs", trial.runs}};
  if (trial.processor_share) json["processor_share"] = *trial.processor_share;
  if (trial.error_share) json["error_share"] = *trial.error_share;
  if (!trial.refusal.empty()) json["refusal"] = trial.refusal;
  return json;
}

/// Reads one record, and refuses in one line what is not as it was written.
class Record {
 public:
  explicit Record(const std::filesystem::path& file) : file_(file.string()) {
    json_ = Json::parse(files::read_text(file, 16 * files::kMiB), nullptr, false);
    if (!json_.is_object()) refuse("", "a record written by sim_server --choice");
  }

  void require(const char* key, const Json& expected) const {
    const auto found = json_.find(key);
    if (found == json_.end() || *found != expected)
      refuse(key, expected.dump() + ", as the scene has it now: choose anew (delete the file)");
  }

  template <class Kind>
  const Kind& choice(const char* key, std::span<const Kind> kinds) const {
    const auto found = json_.find(key);
    const std::string text =
        found != json_.end() && found->is_string() ? found->get<std::string>() : "";
    const auto kind = std::ranges::find(kinds, text, &Kind::name);
    if (kind == kinds.end()) refuse(key, "a name that docs/formats.md lists");
    return *kind;
  }

  double number(const char* key, double least, double most, bool whole = false) const {
    const auto found = json_.find(key);
    if (found == json_.end() || !found->is_number() || (whole && !found->is_number_integer()) ||
        !(found->get<double>() >= least) || !(found->get<double>() <= most))
      refuse(key, std::string(whole ? "a whole number from " : "a number from ") +
                      Json(least).dump() + " to " + Json(most).dump());
    return found->get<double>();
  }

 private:
  [[noreturn]] void refuse(const std::string& key, const std::string& expected) const {
    const auto found = json_.is_object() ? json_.find(key) : json_.end();
    const std::string value = found == json_.end() ? "missing" : "value " + found->dump();
    throw RecordError(file_ + ": " + (key.empty() ? "" : key + ": " + value + ": ") + "expected " +
                      expected);
  }

  std::string file_;
  Json json_;
};

}  // namespace

void write_method_record(const Choices& choices, const scene::SceneDescription& scene,
                         const std::filesystem::path& scene_file,
                         const std::filesystem::path& file) {
  Json json = json_of(choices.method ? choices.method->method : scene.method);
  json["format"] = kFormat;
  json["scene"] = scene.name;
  json["scene_hash"] = hash_of(scene_file, scene);
  json["period_s"] = scene.period_s;
  json["error_target_m"] = scene.error_target_m;
  if (choices.method) {
    json["keeps_rate"] = choices.method->keeps_rate;
    json["meets_target"] = choices.method->meets_target;
    json["haptic_step_ms"] = choices.method->haptic_ms;
    json["fits_haptic_rate"] = choices.method->fits_haptic_rate;
    for (const dynamics::MethodTrial& trial : choices.method->trials)
      json["trials"].push_back(json_of(trial));
  }
  if (choices.rate) {
    json["rate_hz"] = choices.rate->rate_hz;
    json["keeps_force"] = choices.rate->keeps_force;
    json["keeps_share"] = choices.rate->keeps_share;
    for (const RateTrial& trial : choices.rate->trials) json["rates"].push_back(json_of(trial));
  }
  files::write_json(file, json);
}

void take_method_record(scene::SceneDescription& scene, const std::filesystem::path& scene_file,
                        const std::filesystem::path& file) {
  const Record record(file);
  record.require("format", kFormat);
  record.require("scene_hash", hash_of(scene_file, scene));
  if (scene.choose_rate)
    scene.period_s = record.number("period_s", 1e-5, 100.0);
  else
    record.require("period_s", scene.period_s);
  if (!scene.choose_method) return;
  record.require("error_target_m", scene.error_target_m);
  const double substeps = record.number("substeps", 0.0, kMaxSubsteps, true);
  scene.method = {.integrator = record.choice("integrator", scene::kMethods.integrators),
                  .solver = record.choice("solver", scene::kMethods.solvers),
                  .substeps = static_cast<int>(substeps),
                  .tolerance_m_s = record.number("tolerance_m_s", 1e-15, 1e3)};
}

}  // namespace stillgrid::sim_server

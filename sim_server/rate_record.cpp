#include "sim_server/rate_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "shared/files/json_file.hpp"

namespace stillgrid::sim_server {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;

/// FNV-1a of the bytes of a scene file and of its hand's, of the spheres and nodes that its meshes
/// were made into, and of maps of stiffness, as hexadecimal digits.
std::string hash_of(const std::filesystem::path& file, const scene::SceneDescription& scene) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](char byte) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  };
  const auto add_file = [&](const std::filesystem::path& one) {
    std::ifstream stream(one, std::ios::binary);
    for (std::istreambuf_iterator<char> byte(stream), end; byte != end; ++byte) add(*byte);
  };
  add_file(file);
  add_file(scene.hand->file);
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
    std::ifstream stream(file);
    json_ = Json::parse(stream, nullptr, false);
    if (!json_.is_object()) refuse("", "a record written by sim_server --choice");
  }

  void require(const char* key, const Json& expected) const {
    const auto found = json_.find(key);
    if (found == json_.end() || *found != expected)
      refuse(key, expected.dump() + ", as the scene has it now: choose anew (delete the file)");
  }

  double number(const char* key, double least, double most) const {
    const auto found = json_.find(key);
    if (found == json_.end() || !found->is_number() || !(found->get<double>() >= least) ||
        !(found->get<double>() <= most))
      refuse(key, "a number from " + Json(least).dump() + " to " + Json(most).dump());
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

void write_rate_record(const RateChoice& choice, const scene::SceneDescription& scene,
                       const std::filesystem::path& scene_file, const std::filesystem::path& file) {
  Json json = {{"format", kFormat},
               {"scene", scene.name},
               {"scene_hash", hash_of(scene_file, scene)},
               {"method", scene::describe(scene.method)},
               {"period_s", scene.period_s},
               {"rate_hz", choice.rate_hz},
               {"keeps_force", choice.keeps_force},
               {"keeps_share", choice.keeps_share}};
  for (const RateTrial& trial : choice.trials) json["rates"].push_back(json_of(trial));
  files::write_json(file, json);
}

void read_rate_record(scene::SceneDescription& scene, const std::filesystem::path& scene_file,
                      const std::filesystem::path& file) {
  const Record record(file);
  record.require("format", kFormat);
  record.require("scene_hash", hash_of(scene_file, scene));
  record.require("method", scene::describe(scene.method));
  scene.period_s = record.number("period_s", 1e-5, 100.0);
}

}  // namespace stillgrid::sim_server

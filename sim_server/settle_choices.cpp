#include "sim_server/settle_choices.hpp"

#include <spdlog/spdlog.h>

#include <cstdio>
#include <ostream>
#include <string>
#include <variant>

#include "shared/files/whole_file.hpp"
#include "sim_server/chooser.hpp"

namespace stillgrid::sim_server {
namespace {

void tell(const std::string& line) {
  spdlog::info("{}", line);
}

void write_records(const Choice& choice, const std::filesystem::path& file) {
  if (file.empty()) return;
  files::write_whole(file, [&](std::ostream& out) {
    for (const choice::Record& record : choice.records) out << choice::json_line(record) << '\n';
  });
}

void print_table(const std::string& title, std::span<const choice::Record> records) {
  std::printf("%s\n\n%s\n", title.c_str(),
              choice::table_of(records, dynamics::kWorkPerProcessor_ms).c_str());
}

void explain_contacts(const scene::SceneDescription& scene) {
  for (const bodies::BodyDescription& body : scene.bodies) {
    const auto* const mesh = std::get_if<bodies::RigidMeshBody>(&body.shape);
    if (mesh != nullptr && !mesh->contacts.empty())
      print_table("contact of " + body.name, mesh->contacts);
  }
}

}  // namespace

void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const std::filesystem::path& records) {
  if (scene.choose_rate) {
    const Choice choice = choose(scene, candidates_of(scene, false), kStartWork, tell);
    scene.period_s = choice.chosen.scene.period_s;
    scene.method = choice.chosen.scene.method;
    spdlog::info("rate chosen: {}; --explain prints the candidates", choice.chosen.record.name);
    if (const std::string complaint = complaint_of(choice); !complaint.empty())
      spdlog::warn("rate_hz: {}", complaint);
    write_records(choice, records);
  } else if (scene.choose_method) {
    const dynamics::MethodChoice choice =
        dynamics::choose_method(dynamics::load_of(world), scene.period_s);
    scene.method = choice.method;
    spdlog::info("method chosen: {}: {}", scene::describe(scene.method), choice.why);
  }
}

void explain_choices(const scene::SceneDescription& scene, const bodies::World& world,
                     const std::filesystem::path& records) {
  std::optional<Choice> choice;
  if (scene.hand) choice = choose(scene, candidates_of(scene, true), kExplainWork, tell);
  explain_contacts(scene);
  const dynamics::SceneLoad load = dynamics::load_of(world);
  const dynamics::MethodChoice method = dynamics::choose_method(load, scene.period_s);
  std::printf("%s: %.0f nodes, %.0f springs, %.0f rigid bodies, %.0f moving spheres\n",
              scene.name.c_str(), load.nodes, load.springs, load.rigid_bodies, load.spheres);
  std::printf("method by the spectrum: %s: %s\n", scene::describe(method.method).c_str(),
              method.why.c_str());
  if (!scene.choose_method)
    std::printf("the scene names %s\n", scene::describe(scene.method).c_str());
  if (!choice) return;
  std::printf("truth: velocity_verlet at %g Hz, known to %.3g %%; hand %s over %.3g s\n", kTruth_hz,
              100.0 * choice->truth_error_share, scene.hand->file.filename().c_str(),
              choice->watched_s);
  print_table("at most " + std::to_string(std::lround(100.0 * scene.processor_share)) +
                  " % of a processor; work is counted, not timed",
              choice->records);
  std::printf("chosen: %s\n", choice->chosen.record.name.c_str());
  if (const std::string complaint = complaint_of(*choice); !complaint.empty())
    std::printf("%s\n", complaint.c_str());
  write_records(*choice, records);
}

}  // namespace stillgrid::sim_server

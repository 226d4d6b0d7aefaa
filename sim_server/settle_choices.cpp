#include "sim_server/settle_choices.hpp"

#include <spdlog/spdlog.h>

#include <cstdio>
#include <stdexcept>
#include <string>

#include "shared/realtime/processor_time.hpp"
#include "sim_server/explain.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/method_record.hpp"

namespace stillgrid::sim_server {
namespace {

void tell(const std::string& line) {
  spdlog::info("{}", line);
}

/// A hand that cannot be followed is refused before anything is tried.
void look_at_hand(const scene::SceneDescription& scene) {
  if (scene.hand) (void)HandPath(scene.hand->file, scene.device);
}

void choose_both(scene::SceneDescription& scene, const bodies::World& world, Choices& choices) {
  if (scene.choose_method) {
    choices.method = dynamics::choose_method(scene, realtime::thread_processor_s, tell);
    scene.method = choices.method->method;
    spdlog::info("method chosen: {}; --explain tells why", scene::describe(scene.method));
    if (!choices.method->keeps_rate)
      spdlog::warn("no method keeps the scene's rate with room to spare: snapshots may be late");
    if (const std::string complaint = target_complaint(*choices.method, scene); !complaint.empty())
      spdlog::warn("error_target_m {}: {}", scene.error_target_m, complaint);
  }
  if (scene.choose_rate) {
    choices.rate = choose_rate(scene, world, kServerBudget_s, realtime::thread_processor_s, tell);
    scene.period_s = 1.0 / choices.rate->rate_hz;
    spdlog::info("rate chosen: {} Hz; --explain tells why", choices.rate->rate_hz);
    if (const std::string complaint = force_complaint(*choices.rate, scene); !complaint.empty())
      spdlog::warn("rate_hz: {}", complaint);
  }
}

}  // namespace

void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const ChoiceFiles& files, bool is_virtual) {
  if (!scene.choose_method && !scene.choose_rate) return;
  if (!files.record.empty() && std::filesystem::exists(files.record)) {
    take_method_record(scene, files.scene, files.record);
    spdlog::info("as recorded: {}, {} Hz", scene::describe(scene.method), 1.0 / scene.period_s);
    return;
  }
  if (is_virtual)
    throw std::runtime_error(
        files.scene.string() + ": simulation." + (scene.choose_method ? "solver" : "rate_hz") +
        ": value \"auto\": expected --choice FILE with a record in virtual time; sim_server "
        "--scene FILE --explain --choice FILE writes one");
  look_at_hand(scene);
  Choices choices;
  choose_both(scene, world, choices);
  if (!files.record.empty()) write_method_record(choices, scene, files.scene, files.record);
}

void explain_choices(scene::SceneDescription scene, const bodies::World& world,
                     const ChoiceFiles& files) {
  look_at_hand(scene);
  std::fputs(explain_contacts(scene).c_str(), stdout);
  Choices choices;
  choices.method = dynamics::choose_method(scene, realtime::thread_processor_s, tell);
  if (scene.choose_method) scene.method = choices.method->method;
  std::fputs(explain(*choices.method, scene).c_str(), stdout);
  if (scene.hand) {
    choices.rate = choose_rate(scene, world, kExplainBudget_s, realtime::thread_processor_s, tell);
    std::fputs(('\n' + explain(*choices.rate, scene)).c_str(), stdout);
    if (scene.choose_rate) scene.period_s = 1.0 / choices.rate->rate_hz;
  }
  if (!files.record.empty()) write_method_record(choices, scene, files.scene, files.record);
}

}  // namespace stillgrid::sim_server

#include "sim_server/settle_choices.hpp"

#include <spdlog/spdlog.h>

#include <cstdio>
#include <stdexcept>
#include <string>

#include "shared/realtime/processor_time.hpp"
#include "sim_server/explain.hpp"
#include "sim_server/hand_path.hpp"
#include "sim_server/rate_record.hpp"

namespace stillgrid::sim_server {
namespace {

void tell(const std::string& line) {
  spdlog::info("{}", line);
}

/// A hand that cannot be followed is refused before anything is tried.
void look_at_hand(const scene::SceneDescription& scene) {
  if (scene.hand) (void)HandPath(scene.hand->file, scene.device);
}

void settle_method(scene::SceneDescription& scene) {
  const dynamics::MethodChoice choice = dynamics::choose_method(scene, tell);
  scene.method = choice.method;
  spdlog::info("method chosen: {}; --explain prints the trials", scene::describe(scene.method));
  if (!choice.keeps_rate)
    spdlog::warn("no method keeps the scene's rate with room to spare: snapshots may be late");
  if (const std::string complaint = target_complaint(choice, scene); !complaint.empty())
    spdlog::warn("error_target_m {}: {}", scene.error_target_m, complaint);
}

}  // namespace

void settle_choices(scene::SceneDescription& scene, const bodies::World& world,
                    const ChoiceFiles& files, bool is_virtual) {
  const bool is_recorded = !files.record.empty() && std::filesystem::exists(files.record);
  if (scene.choose_rate && is_virtual && !is_recorded)
    throw std::runtime_error(files.scene.string() +
                             ": simulation.rate_hz: value \"auto\": expected --choice FILE with a "
                             "record in virtual time; sim_server --scene FILE --explain --choice "
                             "FILE writes one");
  if (scene.choose_method) settle_method(scene);
  if (!scene.choose_rate) return;
  if (is_recorded) {
    read_rate_record(scene, files.scene, files.record);
    spdlog::info("as recorded: {} Hz", 1.0 / scene.period_s);
    return;
  }
  look_at_hand(scene);
  const RateChoice rate =
      choose_rate(scene, world, kServerBudget_s, realtime::thread_processor_s, tell);
  scene.period_s = 1.0 / rate.rate_hz;
  spdlog::info("rate chosen: {} Hz; --explain prints the trials", rate.rate_hz);
  if (const std::string complaint = force_complaint(rate, scene); !complaint.empty())
    spdlog::warn("rate_hz: {}", complaint);
  if (!files.record.empty()) write_rate_record(rate, scene, files.scene, files.record);
}

void explain_choices(scene::SceneDescription scene, const bodies::World& world,
                     const ChoiceFiles& files) {
  look_at_hand(scene);
  std::fputs(explain_contacts(scene).c_str(), stdout);
  const dynamics::MethodChoice choice = dynamics::choose_method(scene, tell);
  std::fputs(explain(choice, scene).c_str(), stdout);
  if (scene.choose_method) scene.method = choice.method;
  if (!scene.hand) return;
  const RateChoice rate =
      choose_rate(scene, world, kExplainBudget_s, realtime::thread_processor_s, tell);
  std::fputs(('\n' + explain(rate, scene)).c_str(), stdout);
  if (scene.choose_rate) scene.period_s = 1.0 / rate.rate_hz;
  if (!files.record.empty()) write_rate_record(rate, scene, files.scene, files.record);
}

}  // namespace stillgrid::sim_server

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim_server/scene/scene_description.hpp"
#include "tests/laboratory/lab.hpp"
#include "tests/laws/hand.hpp"
#include "tests/laws/scene_text.hpp"

namespace stillgrid::laws {

/// All that decides what a law finds: a scene and how it is moved. Its file is a scene file that
/// sim_server takes, the rest in comments "# key: value" at its head.
struct LawCase {
  int law = 0;
  std::uint64_t seed = 1;  // of the jitter; of a drawn case also its number
  SceneText scene;
  std::optional<Hand> hand;  // by formula, or
  std::string device;        // as haptic_server --device takes it, $DATA being the recordings'
                             // folder; neither: nobody
  std::optional<Hand> other_hand;  // by formula, the second of a scene that names two
  std::string transition = "local", model = "grid";
  double latency_share = 0.0;  // what a step costs, of its period
  double jitter = 0.0;
  double duration_s = 1.0;
  std::string until;    // the step that will mend it; empty: it holds
  std::string variant;  // of laws that compare two runs: how the other one differs
  int repeat = 0;       // of laws of cost: how many times the last body is there
};

/// As a file of the corpus.
[[nodiscard]] std::string print_case(const LawCase& law_case);

/// Throws std::runtime_error, one line, for what is no case.
[[nodiscard]] LawCase parse_case(const std::string& text);
[[nodiscard]] LawCase load_case(const std::filesystem::path& file);

/// Throws SceneError.
[[nodiscard]] scene::SceneDescription scene_of(const LawCase& law_case);

/// Thrown where a case needs recordings that are not here.
struct NoData : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The closed loop of the case; `device` of the result is valid as long as `path` lives. Throws
/// NoData, std::runtime_error.
struct CaseLoop {
  laboratory::LabOptions options;
  std::shared_ptr<const void> path;
};
[[nodiscard]] CaseLoop loop_of(const LawCase& law_case, const scene::SceneDescription& scene);

/// The folder of shipped scenes, where those of cases stand: meshes are looked for there.
[[nodiscard]] std::filesystem::path scene_folder();

}  // namespace stillgrid::laws

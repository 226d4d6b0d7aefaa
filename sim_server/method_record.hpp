#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>

#include "sim_server/dynamics/choice/method_choice.hpp"
#include "sim_server/rate_choice.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// A record that cannot serve: one line naming file, key, value and what was expected.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What was chosen for a scene.
struct Choices {
  std::optional<dynamics::MethodChoice> method = {};
  std::optional<RateChoice> rate = {};
};

/// Writes what was chosen for a scene and why, as JSON, for runs in virtual time, in which no clock
/// may decide. scene: with the method and the period that it came to. scene_file: its bytes are
/// part of the record. Throws std::runtime_error if the file cannot be written.
void write_method_record(const Choices& choices, const scene::SceneDescription& scene,
                         const std::filesystem::path& scene_file,
                         const std::filesystem::path& file);

/// Sets what this scene leaves to choose, method and period, as recorded. Throws RecordError if the
/// file is none of ours, or was written for another scene, period, error target, hand or share of a
/// processor.
void take_method_record(scene::SceneDescription& scene, const std::filesystem::path& scene_file,
                        const std::filesystem::path& file);

}  // namespace stillgrid::sim_server

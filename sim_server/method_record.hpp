#pragma once

#include <filesystem>
#include <stdexcept>

#include "sim_server/dynamics/choice/method_choice.hpp"
#include "sim_server/scene/method.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// A record that cannot serve: one line naming file, key, value and what was expected.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes what was chosen for a scene and why, as JSON, for runs in virtual time, in which no clock
/// may decide. scene_file: its bytes are part of the record. Throws std::runtime_error if the file
/// cannot be written.
void write_method_record(const dynamics::MethodChoice& choice, const scene::SceneDescription& scene,
                         const std::filesystem::path& scene_file,
                         const std::filesystem::path& file);

/// The method recorded for this scene at this rate. Throws RecordError if the file is none of ours,
/// or was written for another scene, period or error target.
[[nodiscard]] scene::Method read_method_record(const scene::SceneDescription& scene,
                                               const std::filesystem::path& scene_file,
                                               const std::filesystem::path& file);

}  // namespace stillgrid::sim_server

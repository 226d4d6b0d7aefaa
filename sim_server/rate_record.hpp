#pragma once

#include <filesystem>
#include <stdexcept>

#include "sim_server/rate_choice.hpp"
#include "sim_server/scene/scene_description.hpp"

namespace stillgrid::sim_server {

/// A record that cannot serve: one line with file, key, value and the expected value.
class RecordError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes the rate chosen for a scene and its trials as JSON. Runs in virtual time read it in place
/// of a clock. scene has the chosen period and method. The record holds a hash of the bytes of
/// scene_file. Throws std::runtime_error if the file cannot be written.
void write_rate_record(const RateChoice& choice, const scene::SceneDescription& scene,
                       const std::filesystem::path& scene_file, const std::filesystem::path& file);

/// Sets the recorded period. Throws RecordError if the file is no such record, or was written for
/// another scene, method, hand or share of a processor.
void read_rate_record(scene::SceneDescription& scene, const std::filesystem::path& scene_file,
                      const std::filesystem::path& file);

}  // namespace stillgrid::sim_server

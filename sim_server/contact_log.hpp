#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "sim_server/dynamics/step/simulation.hpp"

namespace stillgrid::sim_server {

/// Writes the forces between bodies to a CSV file, of which docs/formats.md describes the columns.
class ContactLog {
 public:
  /// hands: names of all hands, of an only hand "". Throws std::runtime_error, one line, where the
  /// file cannot be made.
  ContactLog(const std::filesystem::path& file, const std::vector<std::string>& hands);

  /// Adds a row for each two bodies that touch at the end of the last step.
  void add(const dynamics::Simulation& simulation);
  /// Throws std::runtime_error, one line, where something could not be written.
  void finish();

 private:
  std::filesystem::path file_;
  std::vector<std::string> hands_;
  std::ofstream out_;
  std::vector<dynamics::ContactForce> forces_;  // scratch
};

}  // namespace stillgrid::sim_server

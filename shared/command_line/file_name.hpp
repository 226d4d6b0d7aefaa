#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace stillgrid::command_line {

/// A validator of a file's name, which may not be empty.
[[nodiscard]] inline CLI::Validator file_name() {
  return {[](const std::string& file) {
            return file.empty() ? std::string("expected a file") : std::string();
          },
          ""};
}

}  // namespace stillgrid::command_line

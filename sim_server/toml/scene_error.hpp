#pragma once

#include <stdexcept>

namespace stillgrid::toml {

/// A scene file that was refused.
///
/// what() is one line: `FILE:LINE:COLUMN: KEY: value V: expected ...`, with `missing` for V
/// where there is none. Lines and columns count from one.
struct SceneError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace stillgrid::toml

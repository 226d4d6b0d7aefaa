#pragma once

#include <stdexcept>

namespace stillgrid::toml {

/// A scene file that was refused.
///
/// what() is one line: `FILE:LINE:COLUMN: KEY: value V: expected ...`, with `missing` for V
/// where there is none; a key that is likely another misspelt: `FILE:LINE:COLUMN: KEY: value V:
/// unknown key `mass`: did you mean `mass_kg`?`. Of a table with a name it ends with that:
/// ` (body 'ball')`. Lines and columns count from one.
struct SceneError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace stillgrid::toml

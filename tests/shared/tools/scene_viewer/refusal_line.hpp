#pragma once

#include <stdexcept>
#include <string>

namespace stillgrid::scene_viewer {

/// What a refusal says; empty if the call does not refuse.
template <class Call>
std::string refusal_line(Call&& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

}  // namespace stillgrid::scene_viewer

#include "tests/laws/known.hpp"

namespace stillgrid {

std::optional<std::string_view> known_violation(const LawCase&) {
  return std::nullopt;
}

}  // namespace stillgrid

#pragma once

#include <cstdint>

#include "tests/laws/law_case.hpp"

namespace stillgrid::laws {

/// The case of a law and a seed: always the same. Legal by construction: read_scene() takes it,
/// bodies stand apart, springs and dampers are such that an ideal simulation is stable, and numbers
/// have four digits, none of them round.
///
/// What a law cannot speak of is not drawn for it: no undamped body where rest is the law, no jump
/// by design where steps of the force are.
[[nodiscard]] LawCase draw_case(int law, std::uint64_t seed);

}  // namespace stillgrid::laws

#pragma once

#include <cstddef>
#include <span>

#include "tests/fuzz/fuzz_input.hpp"

namespace stillgrid::fuzz {

/// Writes one number that the input chooses into one of the regions: 12 bytes of input, the region,
/// the kind of number, the place (u16, in units of 4 bytes, round the region's end) and the value
/// (u64). Kinds: words as they are, steps from what stands there, small counts, and the floats at
/// which arithmetic turns odd.
void apply_patch(std::span<const std::span<std::byte>> regions, FuzzInput& input);

/// A count of patches (at most 15), then the patches.
void apply_patches(std::span<const std::span<std::byte>> regions, FuzzInput& input);

}  // namespace stillgrid::fuzz

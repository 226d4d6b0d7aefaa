#pragma once

#include <cstdint>

namespace stillgrid {

/// How often operator new has run in this program and the plugins it loaded.
[[nodiscard]] std::uint64_t allocation_count() noexcept;

}  // namespace stillgrid

#pragma once

#include <cstdint>
#include <optional>

namespace stillgrid::devices {

/// How often operator new has run in this program and the plugins it loaded; nothing where
/// a sanitizer's operator new stands in the way.
[[nodiscard]] std::optional<std::uint64_t> allocation_count() noexcept;

}  // namespace stillgrid::devices

#pragma once

#include <cstddef>
#include <string>

namespace stillgrid::device {

/// A driver's text as one line that may stand in any file: up to its zero, at most most_bytes,
/// control characters as spaces, and '?' for each byte that is no UTF-8. Null is empty.
[[nodiscard]] std::string line_of(const char* text, std::size_t most_bytes);

}  // namespace stillgrid::device

#pragma once

#include <algorithm>
#include <cstring>
#include <string>

#include "proto/device_plugin.h"

namespace stillgrid::devices {

/// Copies what fits, zero at its end.
template <std::size_t Size>
void copy_text(char (&to)[Size], const std::string& from) noexcept {
  const std::size_t length = std::min(from.size(), Size - 1);
  std::memcpy(to, from.data(), length);
  std::memset(to + length, 0, Size - length);
}

/// One device of a listing. option: key=value that chooses it; library: the user's, may be empty.
inline void fill_listing(stillgrid_device_listing& listing, const std::string& name,
                         const std::string& serial, const std::string& option,
                         const std::string& library) {
  copy_text(listing.name, name);
  copy_text(listing.serial, serial);
  const std::string both = library.empty() ? option : "library=" + library + "," + option;
  copy_text(listing.options, both.size() < sizeof listing.options ? both : option);
}

}  // namespace stillgrid::devices

#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace stillgrid {

/// Gives the keys of a scene of format 1 the names of format 2 (shared/files/old_names.hpp), with
/// their values and places in the file; of a table that has both names neither is touched.
///
/// Returns a line for each old name, at the first place where it stands.
[[nodiscard]] std::vector<std::string> renew_format_1(toml::table& document,
                                                      const std::string& file);

}  // namespace stillgrid

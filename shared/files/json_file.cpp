#include "shared/files/json_file.hpp"

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "shared/files/whole_file.hpp"

namespace stillgrid::files {

void write_json(const std::filesystem::path& file, const nlohmann::json& json) {
  const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  write_whole(file, [&](std::ostream& out) { out << text << '\n'; });
}

}  // namespace stillgrid::files

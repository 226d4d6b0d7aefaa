#include "shared/tools/scene_viewer/old_view.hpp"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "shared/files/old_names.hpp"
#include "shared/tools/scene_viewer/checked_json.hpp"

namespace stillgrid::scene_viewer {
namespace {

using Json = nlohmann::json;

Json flags_of_today(const Json& flags) {
  Json renewed = Json::array();
  for (const Json& flag : flags) {
    const bool is_name = flag.is_string();
    renewed.push_back(
        is_name ? Json(files::name_of_today(files::kOldFlags, flag.get<std::string>())) : flag);
  }
  return renewed;
}

Json with_names_of_today(const Json& old) {
  if (old.is_array()) {
    Json renewed = Json::array();
    for (const Json& value : old) renewed.push_back(with_names_of_today(value));
    return renewed;
  }
  if (!old.is_object()) return old;
  Json renewed = Json::object();
  for (const auto& [key, value] : old.items())
    renewed[std::string(files::name_of_today(files::kOldViewKeys, key))] =
        key == "flags" && value.is_array() ? flags_of_today(value) : with_names_of_today(value);
  return renewed;
}

}  // namespace

std::string scene_of_version_1(const std::string& message) {
  const Json old = parse_shallow<Json>(message);
  if (old.is_discarded()) return message;
  return with_names_of_today(old).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string frame_of_version_1(const std::string& message) {
  std::uint32_t length = 0;
  if (message.size() < sizeof length) return message;
  std::memcpy(&length, message.data(), sizeof length);
  if (length > message.size() - sizeof length) return message;
  std::string head = scene_of_version_1(message.substr(sizeof length, length));
  head.append((4 - head.size() % 4) % 4, ' ');  // the arrays stay aligned
  const auto new_length = static_cast<std::uint32_t>(head.size());
  std::string renewed(reinterpret_cast<const char*>(&new_length), sizeof new_length);
  return renewed.append(head).append(message, sizeof length + length);
}

}  // namespace stillgrid::scene_viewer

#include "sim_server/scene/format_1.hpp"

#include <array>
#include <utility>

#include "shared/files/old_names.hpp"

namespace stillgrid {
namespace {

/// Where each old key stands first; a line of zero: nowhere.
using Places = std::array<toml::source_position, kOldSceneKeys.size()>;

void renew(toml::table& table, Places& places) {
  for (std::size_t i = 0; i < kOldSceneKeys.size(); ++i) {
    const auto& [before, now] = kOldSceneKeys[i];
    const auto found = table.find(before);
    if (found == table.end() || table.contains(now)) continue;
    if (!places[i]) places[i] = found->first.source().begin;
    // The place goes with the key: a refusal names it.
    const toml::key renamed(now, toml::source_region(found->first.source()));
    found->second.visit([&](auto& value) { table.insert(renamed, std::move(value)); });
    table.erase(before);
  }
}

void renew_all(toml::node& node, Places& places) {
  if (toml::table* const table = node.as_table()) {
    renew(*table, places);
    for (auto&& [key, value] : *table) renew_all(value, places);
  } else if (toml::array* const array = node.as_array()) {
    for (toml::node& value : *array) renew_all(value, places);
  }
}

}  // namespace

std::vector<std::string> renew_format_1(toml::table& document, const std::string& file) {
  Places places{};
  renew_all(document, places);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i])
      lines.push_back(file + ":" + std::to_string(places[i].line) + ":" +
                      std::to_string(places[i].column) + ": " +
                      std::string(kOldSceneKeys[i].before) + " is of format 1: format 2 names it " +
                      std::string(kOldSceneKeys[i].now));
  return lines;
}

}  // namespace stillgrid

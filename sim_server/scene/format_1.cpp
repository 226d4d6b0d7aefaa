#include "sim_server/scene/format_1.hpp"

#include <algorithm>
#include <utility>

#include "shared/files/old_names.hpp"
#include "sim_server/toml/refusal.hpp"

namespace stillgrid::scene {
namespace {

/// Calls visit(table, prefix of its keys in messages) for each table of a document, outer first.
template <class Node, class Visit>
void for_each_table(Node& node, const std::string& prefix, const Visit& visit) {
  if (auto* const table = node.as_table()) {
    visit(*table, prefix);
    for (auto&& [key, value] : *table)
      for_each_table(value, prefix + std::string(key.str()) + ".", visit);
  } else if (auto* const array = node.as_array()) {
    for (auto& value : *array) for_each_table(value, prefix, visit);
  }
}

void renew(::toml::table& table, const std::string& prefix, const std::string& file,
           std::vector<RenewedKey>& renewed) {
  for (const auto& [before, now] : files::kOldSceneKeys) {
    const auto found = table.find(before);
    if (found == table.end()) continue;
    const ::toml::source_position where = found->first.source().begin;
    if (table.contains(now))
      throw toml::scene_error(file, where, prefix + std::string(before), toml::shown(found->second),
                              std::string(now) + " alone, which is the same key");
    const auto known = std::find_if(renewed.begin(), renewed.end(),
                                    [name = now](const auto& key) { return key.now == name; });
    if (known == renewed.end())
      renewed.push_back({before, now, where});
    else
      known->where = std::min(known->where, where);
    // The place goes with the key: a refusal names it.
    const ::toml::key renamed(now, ::toml::source_region(found->first.source()));
    found->second.visit([&](auto& value) { table.insert(renamed, std::move(value)); });
    table.erase(before);
  }
}

}  // namespace

std::vector<RenewedKey> renew_format_1(::toml::table& document, const std::string& file) {
  std::vector<RenewedKey> renewed;
  for_each_table(document, "", [&](::toml::table& table, const std::string& prefix) {
    renew(table, prefix, file, renewed);
  });
  std::sort(renewed.begin(), renewed.end(),
            [](const RenewedKey& a, const RenewedKey& b) { return a.where < b.where; });
  return renewed;
}

void refuse_format_1(const ::toml::table& document, const std::string& file) {
  for_each_table(document, "", [&](const ::toml::table& table, const std::string& prefix) {
    for (const auto& [before, now] : files::kOldSceneKeys)
      if (const auto found = table.find(before); found != table.end())
        throw toml::scene_error(file, found->first.source().begin, prefix + std::string(before),
                                toml::shown(found->second),
                                "no such key: format 2 calls it " + std::string(now));
  });
}

std::vector<std::string> lines_of(const std::vector<RenewedKey>& renewed, const std::string& file) {
  std::vector<std::string> lines;
  for (const auto& [before, now, where] : renewed)
    lines.push_back(file + ":" + std::to_string(where.line) + ":" + std::to_string(where.column) +
                    ": " + std::string(before) + " is of format 1: format 2 calls it " +
                    std::string(now));
  return lines;
}

toml::SceneError with_names_of_file(const toml::SceneError& refusal,
                                    const std::vector<RenewedKey>& renewed) {
  std::string names;
  for (const auto& [before, now, where] : renewed)
    names.append(names.empty() ? "; of format 1: " : ", ")
        .append(before)
        .append(", which format 2 calls ")
        .append(now);
  return toml::SceneError(refusal.what() + names);
}

}  // namespace stillgrid::scene

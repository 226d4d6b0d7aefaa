#include "tests/laboratory/fit_run/fit_scene.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "shared/files/text_file.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/laboratory/methods/laboratory_methods.hpp"

namespace stillgrid::fit_run {
namespace {

using Path = std::vector<std::string>;

/// One setting, taken apart: "body.tissue.spheres.spacing_m=0.02".
struct Setting {
  const std::string& text;
  std::string key;
  ::toml::table value;  // under "value"
};

[[noreturn]] void refuse(const std::string& setting, const std::string& expected) {
  std::string shown = setting;
  std::replace(shown.begin(), shown.end(), '\n', ' ');
  throw std::runtime_error("--set: value '" + shown + "': expected " + expected);
}

Setting parse_setting(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(text, "KEY=VALUE");
  constexpr const char* kExpected =
      "KEY=VALUE with a value as TOML has it: 0.02, 2, true, \"auto\"";
  try {
    Setting setting{text, text.substr(0, equals),
                    ::toml::parse("value =" + text.substr(equals + 1))};
    if (setting.value.size() != 1) refuse(text, kExpected);  // more lines, with keys of their own
    return setting;
  } catch (const ::toml::parse_error&) {
    refuse(text, kExpected);
  }
}

Path split(std::string_view key) {
  Path path(1);
  for (const char c : key) {
    if (c == '.')
      path.emplace_back();
    else
      path.back() += c;
  }
  return path;
}

/// The table of an array whose `name` the key goes on with, the longest such; the rest of the key
/// is what follows it.
::toml::table& named_table(::toml::table& root, const Setting& setting, std::string_view kind,
                           std::string_view& rest) {
  ::toml::table* found = nullptr;
  std::size_t longest = 0;
  std::string names;
  if (auto* const array = root[kind].as_array()) {
    for (::toml::node& node : *array) {
      auto* const table = node.as_table();
      const auto name = table == nullptr ? std::nullopt : (*table)["name"].value<std::string>();
      if (!name) continue;
      names += (names.empty() ? "" : ", ") + *name;
      if (rest.size() > name->size() + 1 && rest.starts_with(*name) && rest[name->size()] == '.' &&
          name->size() >= longest) {
        found = table;
        longest = name->size();
      }
    }
  }
  if (found == nullptr)
    refuse(setting.text, std::string(kind) + ".NAME.KEY with one of the scene's: " + names);
  rest.remove_prefix(longest + 1);
  return *found;
}

::toml::table& sub_table(::toml::table& table, const std::string& key, const Setting& setting) {
  if (!table.contains(key)) table.insert(key, ::toml::table{});
  auto* const found = table[key].as_table();
  if (found == nullptr) refuse(setting.text, "a key of a table; '" + key + "' is none");
  return *found;
}

/// Takes away what the key just set stands for, but for what is set itself.
void drop_contradicted(::toml::table& table, const std::string& key,
                       const std::set<const ::toml::node*>& set) {
  const auto drop = [&](std::initializer_list<std::string_view> others) {
    for (const std::string_view other : others)
      if (const ::toml::node* node = table.get(other); node != nullptr && !set.contains(node))
        table.erase(other);
  };
  if (key == "rate_hz") drop({"period_s"});
  if (key == "period_s") drop({"rate_hz"});
  if (key == "integrator") drop({"substeps", "tolerance_m_s", "error_target_m"});
  constexpr std::array<std::string_view, 5> kMeshSpheres = {
      "file", "tolerance_m", "surface_spacing_m", "volume_spacing_m", "feel"};
  if (std::find(kMeshSpheres.begin(), kMeshSpheres.end(), key) == kMeshSpheres.end()) return;
  for (const std::string_view other : kMeshSpheres)
    if (other != key) drop({other});
  if (key != "feel") drop({"tool_radius_m", "press_depth_m"});
}

}  // namespace

std::filesystem::path find_scene(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const std::array<fs::path, 3> files = {
      name,
      // Installed: PREFIX/libexec/stillgrid/fit_run.
      program.parent_path().parent_path().parent_path() / "share/stillgrid/scenes" /
          (name + ".toml"),
      fs::path(STILLGRID_SOURCE_DIR "/sim_server/scene/scenes") / (name + ".toml")};
  const auto* const found = std::find_if(files.begin(), files.end(), [&](const fs::path& file) {
    return fs::is_regular_file(file, error);
  });
  if (found == files.end())
    throw std::runtime_error("SCENE: value '" + name +
                             "': expected a scene file, or the name of a scene that ships");
  return *found;
}

std::string with_settings(const std::string& text, const std::vector<std::string>& settings) {
  ::toml::table root = ::toml::parse(std::string_view(text));
  struct Done {
    ::toml::table* table;
    std::string key;
  };
  std::vector<Done> done;
  for (const std::string& one : settings) {
    const Setting setting = parse_setting(one);
    std::string_view rest = setting.key;
    ::toml::table* table = &root;
    for (const std::string_view kind : {"body", "material"}) {
      if (!rest.starts_with(std::string(kind) + ".")) continue;
      rest.remove_prefix(kind.size() + 1);
      table = &named_table(root, setting, kind, rest);
    }
    Path path = split(rest);
    if (std::any_of(path.begin(), path.end(), [](const std::string& part) { return part.empty(); }))
      refuse(one, "KEY=VALUE with a key such as simulation.rate_hz or body.NAME.stiffness_scale");
    for (std::size_t i = 0; i + 1 < path.size(); ++i) table = &sub_table(*table, path[i], setting);
    const ::toml::node& value = *setting.value.get("value");
    if (table == &root || value.is_table() || (*table)[path.back()].is_table())
      refuse(one, "TABLE.KEY=VALUE where VALUE is a number, a string, true, false or a list");
    table->insert_or_assign(path.back(), value);
    done.push_back({table, path.back()});
  }
  std::set<const ::toml::node*> set;
  for (const Done& one : done) set.insert(one.table->get(one.key));
  for (const Done& one : done) drop_contradicted(*one.table, one.key, set);
  std::ostringstream out;
  out << root;
  return out.str();
}

scene::SceneDescription load_scene_with(const std::filesystem::path& file,
                                        const std::vector<std::string>& settings) {
  if (settings.empty()) return scene::load_scene(file);
  std::string text;
  try {
    text = with_settings(files::read_text(file, 64 * files::kMiB), settings);
  } catch (const ::toml::parse_error&) {
    return scene::load_scene(file);  // refuses the file, and says where
  } catch (const toml::SceneError&) {
    return scene::load_scene(file);
  }
  try {
    return scene::read_scene(text, file, laboratory::laboratory_methods());
  } catch (const toml::SceneError& error) {
    (void)scene::load_scene(file);  // what is wrong without the settings is told of the file
    std::string shown;
    for (const std::string& setting : settings) shown += (shown.empty() ? "" : " ") + setting;
    // Lines and columns are those of no file that the user has.
    std::string why = error.what();
    why.erase(0, std::min(why.size(), file.string().size() + 1));
    for (int i = 0; i < 2 && why.find(':') != std::string::npos; ++i)
      why.erase(0, why.find(':') + 1);
    throw std::runtime_error("--set: value '" + shown + "':" + why);
  }
}

}  // namespace stillgrid::fit_run

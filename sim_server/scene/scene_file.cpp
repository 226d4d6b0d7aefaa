#include "sim_server/scene/scene_file.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <variant>
#include <vector>

#include "proto/distance_field.hpp"
#include "proto/segment_header.hpp"
#include "proto/tool_segment.hpp"
#include "shared/files/text_file.hpp"
#include "shared/publication/hands.hpp"
#include "sim_server/bodies/kinds/mesh_fields.hpp"
#include "sim_server/bodies/kinds/mesh_shells.hpp"
#include "sim_server/scene/body_reader.hpp"
#include "sim_server/scene/joint_reader.hpp"
#include "sim_server/toml/refusal.hpp"
#include "sim_server/toml/toml_depth.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::scene {
namespace {

constexpr int kFormat = 2;
constexpr std::size_t kMaxMaterials = 64;
constexpr std::size_t kMaxPlanes = 64;
constexpr double kShortestPeriod_s = 1e-5, kLongestPeriod_s = 100.0;
constexpr int kMaxSubsteps = 10000;
constexpr std::size_t kMaxToolSpheres = 16;
constexpr double kLongestSettle_s = 600.0;
constexpr double kDefaultToolRadius_m = 0.005;
constexpr std::array<std::string_view, 10> kTables = {
    "format", "world", "simulation", "grid", "tool", "device", "hand", "material", "body", "joint"};

std::string line_of(const std::string& text, ::toml::source_index line) {
  std::istringstream lines(text);
  std::string found;
  for (::toml::source_index i = 0; i < line; ++i) {
    if (!std::getline(lines, found)) return "end of file";
  }
  return '"' + toml::shortened(found) + '"';
}

::toml::table parse_text(const std::string& text, const std::string& file) {
  if (const auto deep = toml::find_deep_place(text))
    throw toml::scene_error(file, {deep->line, deep->column}, "syntax", line_of(text, deep->line),
                            deep->expected);
  try {
    return ::toml::parse(std::string_view(text));
  } catch (const ::toml::parse_error& error) {
    const ::toml::source_position where = error.source().begin;
    throw toml::scene_error(file, where, "syntax", line_of(text, where.line),
                            "TOML: " + std::string(error.description()));
  }
}

void read_world(toml::TableReader table, SceneDescription& scene) {
  scene.gravity_m_s2 = table.vector_or("gravity_m_s2", scene.gravity_m_s2);
  table.finish();
}

/// "auto" chooses the whole method; any other integrator is named with its keys.
void read_method(toml::TableReader& table, Integrators integrators, SceneDescription& scene) {
  Method& method = scene.method;
  if (table.has("integrator")) {
    std::vector<std::string_view> names;
    for (const IntegratorKind& kind : integrators) names.push_back(kind.name);
    names.push_back("auto");
    const std::size_t chosen = table.choice("integrator", names);
    scene.choose_method = chosen == integrators.size();
    if (!scene.choose_method) method.integrator = integrators[chosen];
  }
  if (scene.choose_method) {
    for (const char* key : {"substeps", "tolerance_m_s"})
      if (table.has(key))
        table.refuse(key, "no such key beside integrator = \"auto\", which chooses it");
    return;
  }
  if (is_explicit(method.integrator) && table.has("tolerance_m_s"))
    table.refuse("tolerance_m_s",
                 "no such key beside an explicit integrator, which solves nothing");
  if (chooses_steps(method.integrator) && table.has("substeps"))
    table.refuse("substeps", "no such key beside this integrator, which divides a step by itself");
  if (table.has("substeps")) method.substeps = table.integer("substeps", {1, kMaxSubsteps});
  method.tolerance_m_s =
      table.number_or("tolerance_m_s", toml::Bound::kPositive, method.tolerance_m_s);
}

void read_simulation(toml::TableReader table, Integrators integrators, SceneDescription& scene) {
  if (table.has("rate_hz") && table.has("period_s")) {
    table.refuse("period_s", "rate_hz or period_s, not both");
  }
  if (table.has_text("rate_hz"))
    table.refuse("rate_hz", "a number: no rate is chosen; write 10 to 100, snapshots a second");
  if (table.has("rate_hz")) scene.period_s = 1.0 / table.number("rate_hz", toml::Bound::kAny);
  if (table.has("period_s")) scene.period_s = table.number("period_s", toml::Bound::kPositive);
  if (!(scene.period_s >= kShortestPeriod_s && scene.period_s <= kLongestPeriod_s)) {
    table.refuse(table.has("period_s") ? "period_s" : "rate_hz",
                 "a period from 1e-05 to 100 s, a rate from 0.01 to 100000 Hz");
  }
  read_method(table, integrators, scene);
  scene.sleeping = table.flag_or("sleeping", scene.sleeping);
  table.finish();
}

void read_grid(toml::TableReader table, SceneDescription& scene) {
  scene.voxel_ratio = table.number_or("voxel_ratio", toml::Bound::kPositive, scene.voxel_ratio);
  table.finish();
}

void read_tool(toml::TableReader table, Hand& hand) {
  if (table.has("radius_m") && table.has("spheres")) {
    table.refuse("spheres", "radius_m or spheres, not both");
  }
  if (table.has("spheres")) {
    for (toml::TableReader& sphere : table.tables("spheres")) {
      hand.tool.push_back({sphere.vector_or("position_m", Eigen::Vector3d::Zero()),
                           sphere.number("radius_m", toml::Bound::kPositive)});
      sphere.finish();
    }
    if (hand.tool.empty() || hand.tool.size() > kMaxToolSpheres) {
      table.refuse("spheres", "1 to " + std::to_string(kMaxToolSpheres) + " spheres, found " +
                                  std::to_string(hand.tool.size()));
    }
  } else {
    hand.tool.push_back(
        {Eigen::Vector3d::Zero(),
         table.number_or("radius_m", toml::Bound::kPositive, kDefaultToolRadius_m)});
  }
  table.refuse_gone("slip_speed_m_s", "friction of a tool sticks");
  constexpr std::array<std::string_view, 2> kContacts = {"proxy", "penalty"};
  if (table.has("contact") && table.choice("contact", kContacts) == 1)
    hand.tool_slip_speed_m_s = kPenaltySlip_m_s;
  table.finish();
}

void read_device(toml::TableReader table, Hand& hand) {
  hand.device.position_m = table.vector_or("position_m", hand.device.position_m);
  hand.device.orientation = table.orientation_or_identity("orientation_xyzw");
  hand.device.scale = table.number_or("scale", toml::Bound::kPositive, hand.device.scale);
  // What a reader of the published scene would refuse is better refused here, with its line.
  if (hand.device.position_m.cwiseAbs().maxCoeff() > proto::kLargestNumber)
    table.refuse("position_m", "numbers from -1e6 to 1e6");
  if (hand.device.scale > proto::kLargestNumber) table.refuse("scale", "at most 1e6");
  table.finish();
}

HandDescription read_typical_hand(toml::TableReader table) {
  HandDescription hand{.file = table.file("file"), .line = table.line()};
  hand.settle_s = table.number_or("settle_s", toml::Bound::kNotNegative, 0.0);
  if (hand.settle_s > kLongestSettle_s) table.refuse("settle_s", "at most 600 s");
  table.finish();
  return hand;
}

Hand read_hand(toml::TableReader& table) {
  Hand hand;
  hand.name = table.name("name");
  if (!publication::hand_complaint(hand.name).empty())
    table.refuse("name", "1 to 16 letters, digits, '_' or '-'");
  read_tool(table.table("tool"), hand);
  read_device(table.table("device"), hand);
  table.finish();
  return hand;
}

MaterialDescription read_material(toml::TableReader& table) {
  MaterialDescription material;
  material.name = table.name("name");
  material.contact_stiffness_N_per_m =
      table.number("contact_stiffness_N_per_m", toml::Bound::kPositive);
  material.contact_damping_N_s_per_m =
      table.number_or("contact_damping_N_s_per_m", toml::Bound::kNotNegative, 0.0);
  material.friction = table.number_or("friction", toml::Bound::kNotNegative, 0.0);
  material.slip_speed_m_s =
      table.number_or("slip_speed_m_s", toml::Bound::kPositive, material.slip_speed_m_s);
  table.finish();
  return material;
}

/// Notes a name, which nothing else of its sort may have.
void take_name(toml::TableReader& table, const std::string& name,
               std::unordered_set<std::string>& names) {
  if (!names.insert(name).second) table.refuse("name", "a name that nothing else of its sort has");
}

/// Either [tool], [device] and [hand], or a [[hand]] each.
void read_hands(toml::TableReader& document, SceneDescription& scene) {
  if (!document.has_tables("hand")) {
    Hand only;
    read_tool(document.table("tool"), only);
    read_device(document.table("device"), only);
    scene.tool = only.tool;
    scene.tool_slip_speed_m_s = only.tool_slip_speed_m_s;
    scene.device = only.device;
    if (document.has("hand")) scene.hand = read_typical_hand(document.table("hand"));
    return;
  }
  for (const char* key : {"tool", "device"})
    if (document.has(key))
      document.refuse(key, "no such table beside [[hand]], each of which has its own");
  std::unordered_set<std::string> names;
  for (toml::TableReader& table : document.tables("hand")) {
    if (scene.hands.size() == proto::kMaxHands)
      table.refuse("name", "at most " + std::to_string(proto::kMaxHands) + " hands");
    scene.hands.push_back(read_hand(table));
    take_name(table, scene.hands.back().name, names);
  }
}

void read_materials(toml::TableReader& document, SceneDescription& scene) {
  std::unordered_set<std::string> names;
  for (toml::TableReader& table : document.tables("material")) {
    if (scene.materials.size() == kMaxMaterials) {
      table.refuse("name", "at most " + std::to_string(kMaxMaterials) + " materials");
    }
    scene.materials.push_back(read_material(table));
    take_name(table, scene.materials.back().name, names);
  }
}

bodies::FieldScene field_scene_of(const SceneDescription& scene) {
  bodies::FieldScene of{.least_tool_radius_m = std::numeric_limits<double>::infinity()};
  for (const Hand& hand : hands_of(scene))
    for (const ToolSphere& sphere : hand.tool) {
      of.least_tool_radius_m = std::min(of.least_tool_radius_m, sphere.radius_m);
      of.largest_tool_radius_m = std::max(of.largest_tool_radius_m, sphere.radius_m);
    }
  for (const MaterialDescription& material : scene.materials)
    of.materials_N_per_m.push_back(material.contact_stiffness_N_per_m);
  return of;
}

void read_bodies(toml::TableReader& document, SceneDescription& scene) {
  std::unordered_set<std::string> names;
  std::size_t planes = 0, scaled = 0, fields = 0;
  for (toml::TableReader& table : document.tables("body")) {
    const bodies::BodyDescription& body =
        scene.bodies.emplace_back(read_body(table, scene.materials, scene.notes));
    take_name(table, body.name, names);
    if (std::holds_alternative<bodies::PlaneBody>(body.shape)) ++planes;
    if (planes > kMaxPlanes) {
      table.refuse("kind", "at most " + std::to_string(kMaxPlanes) + " planes");
    }
    const auto* const mesh = std::get_if<bodies::RigidMeshBody>(&body.shape);
    const auto* const compound = std::get_if<bodies::CompoundBody>(&body.shape);
    fields += mesh != nullptr && mesh->asked_field ? 1
              : compound != nullptr                ? compound->shapes.size()
                                                   : 0;
    if (fields > proto::kMaxFields)
      table.refuse("kind", "at most " + std::to_string(proto::kMaxFields) +
                               " fields and exact shapes; a rigid_box with `spheres` is neither");
    // A body whose stiffness is its own is published with a material of its own.
    scaled += body.stiffness_scale != 1.0 ? 1 : 0;
    if (scene.materials.size() + scaled > kMaxMaterials)
      table.refuse("stiffness_scale",
                   "at most " + std::to_string(kMaxMaterials) +
                       " materials and bodies of a stiffness of their own together");
  }
}

void read_joints(toml::TableReader& document, SceneDescription& scene) {
  std::unordered_set<std::string> names;
  for (toml::TableReader& table : document.tables("joint")) {
    scene.joints.push_back(read_joint(table, scene.bodies));
    take_name(table, scene.joints.back().name, names);
  }
}

/// A scene with a soft mesh that names no integrator is explicit: substeps cost less there than the
/// solver's products.
void serve_meshes(bool names_method, SceneDescription& scene) {
  const bool has_mesh = std::ranges::any_of(scene.bodies, [](const bodies::BodyDescription& body) {
    return body.motion == bodies::Motion::kFree &&
           std::holds_alternative<bodies::SoftMeshBody>(body.shape);
  });
  if (has_mesh && !names_method) scene.method.integrator = IntegratorKind::kVelocityVerlet;
}

void read_tables(toml::TableReader& document, Integrators integrators, const std::string& file,
                 SceneDescription& scene) {
  // First, or a body would miss the material of a table [[materials]].
  document.allow_only(kTables);
  read_world(document.table("world"), scene);
  toml::TableReader simulation = document.table("simulation");
  bool names_method = false;
  for (const char* key : {"integrator", "substeps", "tolerance_m_s"})
    names_method = names_method || simulation.has(key);
  const bool names_rate = simulation.has("rate_hz") || simulation.has("period_s");
  read_simulation(std::move(simulation), integrators, scene);
  read_grid(document.table("grid"), scene);
  read_hands(document, scene);
  read_materials(document, scene);
  read_bodies(document, scene);
  read_joints(document, scene);
  serve_meshes(names_method, scene);
  scene.names_step = names_rate || names_method;
  const bodies::FieldScene around = field_scene_of(scene);
  bodies::cover_shells(scene.bodies, around, scene.notes);
  bodies::make_fields(scene.bodies, around, file, scene.notes);
}

}  // namespace

SceneDescription read_scene(const std::string& text, const std::filesystem::path& path,
                            Integrators integrators) {
  const std::string file = path.string();
  ::toml::table parsed = parse_text(text, file);
  toml::TableReader document(parsed, file);

  SceneDescription scene;
  scene.name = path.stem().string();
  // First of all: under another format every other key may mean something else.
  (void)document.integer("format", {kFormat, kFormat});
  read_tables(document, integrators, file, scene);
  return scene;
}

SceneDescription load_scene(const std::filesystem::path& path, Integrators integrators) {
  constexpr std::uintmax_t kMaxBytes = 64 * files::kMiB;
  return read_scene(files::read_text(path, kMaxBytes), path, integrators);
}

void require_one_hand(const SceneDescription& scene, const std::filesystem::path& path) {
  if (scene.hands.empty()) return;
  throw std::runtime_error(path.string() + ": hand: value " + std::to_string(scene.hands.size()) +
                           " hands with names: expected the tables [tool] and [device] of one");
}

}  // namespace stillgrid::scene

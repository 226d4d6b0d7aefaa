#include "sim_server/scene/body_reader.hpp"

#include <array>
#include <iomanip>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim_server/bodies/kinds/body_kinds.hpp"

namespace stillgrid::scene {
namespace {

constexpr double kMaxStiffnessScale = 1e6;  // so that a stiffness stays a float's

const bodies::BodyKind& read_kind(toml::TableReader& table) {
  std::vector<std::string_view> names;
  for (const bodies::BodyKind& kind : bodies::body_kinds()) names.push_back(kind.name);
  return bodies::body_kinds()[table.choice("kind", names)];
}

int read_material(toml::TableReader& table, std::span<const MaterialDescription> materials) {
  std::vector<std::string_view> names;
  for (const MaterialDescription& material : materials) names.push_back(material.name);
  if (names.empty()) table.refuse("material", "a [[material]] of the scene, which has none");
  return static_cast<int>(table.choice("material", names));
}

bodies::Motion read_motion(toml::TableReader& table, const bodies::BodyKind& kind) {
  if (kind.motions(table) == bodies::Motions::kStatic) {
    constexpr std::array<std::string_view, 1> only_static = {"static"};
    if (table.has("motion")) (void)table.choice("motion", only_static);
    return bodies::Motion::kStatic;
  }
  if (!table.has("motion")) return bodies::Motion::kFree;
  constexpr std::array<std::string_view, 3> names = {"free", "static", "prescribed"};
  constexpr std::array motions = {bodies::Motion::kFree, bodies::Motion::kStatic,
                                  bodies::Motion::kPrescribed};
  const std::size_t count = kind.motions(table) == bodies::Motions::kAny ? 3 : 2;
  return motions[table.choice("motion", std::span(names).first(count))];
}

/// As it was written before: a speed along a direction.
void refuse_speed(toml::TableReader& table) {
  if (!table.has_number("velocity_m_s")) return;
  const Eigen::Vector3d direction =
      table.has("direction") ? table.direction("direction") : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d velocity_m_s = table.number("velocity_m_s", toml::Bound::kAny) * direction;
  std::ostringstream expected;
  expected << "a vector, which without `direction` says the same: [" << velocity_m_s.x() << ", "
           << velocity_m_s.y() << ", " << velocity_m_s.z() << "]";
  table.refuse("velocity_m_s", expected.str());
}

std::shared_ptr<const bodies::PrescribedMotion::Keyframes> read_keyframes(
    toml::TableReader& table) {
  constexpr std::size_t kMaxKeyframes = 10000;
  constexpr double kLeastApart_s = 1e-6;
  bodies::PrescribedMotion::Keyframes keyframes;
  for (toml::TableReader& frame : table.tables("keyframes")) {
    const double time_s = frame.number("time_s", toml::Bound::kPositive);
    const double before_s = keyframes.empty() ? 0.0 : keyframes.back().time_s;
    if (!(time_s >= before_s + kLeastApart_s)) {
      std::ostringstream expected;
      expected << std::setprecision(17) << "at least 1e-6 s after the keyframe before, at "
               << before_s << " s";
      frame.refuse("time_s", expected.str());
    }
    keyframes.push_back({time_s, frame.vector("displacement_m")});
    frame.finish();
  }
  if (keyframes.empty() || keyframes.size() > kMaxKeyframes)
    table.refuse("keyframes", "1 to 10000 of { time_s = 1.0, displacement_m = [0, 0, 0.01] }");
  return std::make_shared<const bodies::PrescribedMotion::Keyframes>(std::move(keyframes));
}

bodies::PrescribedMotion read_prescribed(toml::TableReader& table) {
  bodies::PrescribedMotion motion;
  if (table.has("keyframes")) {
    for (const char* other : {"velocity_m_s", "amplitude_m", "frequency_hz", "direction"})
      if (table.has(other)) table.refuse(other, "no such key beside keyframes");
    motion.keyframes = read_keyframes(table);
    return motion;
  }
  const bool is_sine = table.has("amplitude_m") || table.has("frequency_hz");
  if (is_sine && table.has("velocity_m_s")) {
    table.refuse("velocity_m_s", "either velocity_m_s, or amplitude_m with frequency_hz");
  }
  if (is_sine) {
    if (table.has("direction")) motion.direction = table.direction("direction");
    motion.amplitude_m = table.number("amplitude_m", toml::Bound::kPositive);
    motion.frequency_hz = table.number("frequency_hz", toml::Bound::kPositive);
  } else {
    refuse_speed(table);
    motion.velocity_m_s = table.vector("velocity_m_s");
    if (table.has("direction"))
      table.refuse("direction",
                   "no such key beside velocity_m_s, but of amplitude_m with frequency_hz");
  }
  return motion;
}

/// What only another motion has, of the keys that every kind reads alike.
void refuse_of_other_motions(toml::TableReader& table, bodies::Motion motion) {
  struct MotionKey {
    std::string_view key;
    bool free, prescribed;
  };
  constexpr std::array<MotionKey, 7> kKeys = {{{"mass_kg", true, false},
                                               {"velocity_m_s", true, true},
                                               {"angular_velocity_rad_s", true, false},
                                               {"direction", false, true},
                                               {"amplitude_m", false, true},
                                               {"frequency_hz", false, true},
                                               {"keyframes", false, true}}};
  for (const auto& [key, free, prescribed] : kKeys) {
    const bool applies = (motion == bodies::Motion::kFree && free) ||
                         (motion == bodies::Motion::kPrescribed && prescribed);
    if (!table.has(key) || applies)
      continue;  // asked in this order: the second is near to the third
    const std::string own = motion == bodies::Motion::kFree     ? "free"
                            : motion == bodies::Motion::kStatic ? "static"
                                                                : "prescribed";
    table.refuse(key, "no such key of a body whose motion is \"" + own + "\", but of one that is " +
                          (free && prescribed ? "\"free\" or \"prescribed\""
                           : free             ? "\"free\""
                                              : "\"prescribed\""));
  }
}

void read_dynamics(toml::TableReader& table, bodies::BodyDescription& body) {
  refuse_of_other_motions(table, body.motion);
  if (body.motion == bodies::Motion::kPrescribed) body.prescribed = read_prescribed(table);
  if (body.motion != bodies::Motion::kFree) return;
  body.mass_kg = table.number("mass_kg", toml::Bound::kPositive);
  body.velocity_m_s = table.vector_or("velocity_m_s", body.velocity_m_s);
  body.angular_velocity_rad_s =
      table.vector_or("angular_velocity_rad_s", body.angular_velocity_rad_s);
}

/// How much stiffer a body's contacts are than its material.
void read_stiffness_scale(toml::TableReader& table, bodies::BodyDescription& body) {
  if (!table.has("stiffness_scale")) return;
  const double scale = table.number("stiffness_scale", toml::Bound::kAny);
  if (scale < 1.0 / kMaxStiffnessScale || scale > kMaxStiffnessScale)
    table.refuse("stiffness_scale", "a number from 1e-6 to 1e6");
  body.stiffness_scale = scale;
}

}  // namespace

bodies::BodyDescription read_body(toml::TableReader& table,
                                  std::span<const MaterialDescription> materials,
                                  std::vector<std::string>& notes) {
  bodies::BodyDescription body;
  body.line = table.line();
  body.name = table.name("name");
  const bodies::BodyKind& kind = read_kind(table);
  body.material = read_material(table, materials);
  body.motion = read_motion(table, kind);
  const bool may_move = kind.motions(table) != bodies::Motions::kStatic;
  if (may_move) read_dynamics(table, body);
  kind.read(table, body, notes);
  if (may_move) read_stiffness_scale(table, body);
  table.finish();
  return body;
}

}  // namespace stillgrid::scene

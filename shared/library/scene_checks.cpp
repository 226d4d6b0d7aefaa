#include "shared/library/scene_checks.hpp"

#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "shared/collision/sphere_history.hpp"
#include "shared/library/known_part.hpp"
#include "shared/library/numbers.hpp"
#include "shared/publication/hands.hpp"

namespace stillgrid::library {
namespace {

constexpr double kLongestPeriod_s = 10.0;
constexpr double kDefaultTool_m = 0.005;
constexpr double kUnit = 1e-6;  // what a unit vector's square may differ from 1

float f(double x) {
  return static_cast<float>(x);
}

int read_materials(const stillgrid_scene& scene, publication::StaticScene& fixed) {
  if (scene.materials == nullptr || scene.material_count == 0)
    return fail(STILLGRID_E_ARGUMENT, "scene.materials: expected one at least");
  if (scene.material_count > proto::kMaxMaterials)
    return fail(STILLGRID_E_CAPACITY, "scene.material_count: %u: expected %u at most",
                scene.material_count, proto::kMaxMaterials);
  for (std::uint32_t i = 0; i < scene.material_count; ++i) {
    const stillgrid_material& m = scene.materials[i];
    const auto is_law = [](double x) { return is_number(x) && x >= 0.0; };
    if (!is_law(m.stiffness_N_per_m) || !is_law(m.damping_N_s_per_m) || !is_law(m.friction))
      return fail(
          STILLGRID_E_ARGUMENT,
          "scene.materials[%u]: %g N/m, %g N s/m, friction %g: expected numbers of 0 or more", i,
          m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction);
    fixed.materials.push_back({f(m.stiffness_N_per_m), f(m.damping_N_s_per_m), f(m.friction),
                               f(collision::ContactMaterial{}.slip_speed_m_s)});
  }
  return STILLGRID_OK;
}

int read_planes(const stillgrid_scene& scene, publication::StaticScene& fixed) {
  if (scene.plane_count > proto::kMaxPlanes)
    return fail(STILLGRID_E_CAPACITY, "scene.plane_count: %u: expected %u at most",
                scene.plane_count, proto::kMaxPlanes);
  if (scene.plane_count > 0 && scene.planes == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "scene.planes: expected %u of them, not null",
                scene.plane_count);
  for (std::uint32_t i = 0; i < scene.plane_count; ++i) {
    const auto& [n, offset_m, material, body] = scene.planes[i];
    const double size2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(std::abs(size2 - 1.0) < kUnit) || !is_number(offset_m))
      return fail(STILLGRID_E_ARGUMENT,
                  "scene.planes[%u]: normal (%g, %g, %g), offset %g m: expected a unit vector and "
                  "a number",
                  i, n[0], n[1], n[2], offset_m);
    if (material >= scene.material_count)
      return fail(STILLGRID_E_ARGUMENT, "scene.planes[%u].material: %u: expected 0 to %u", i,
                  material, scene.material_count - 1);
    fixed.planes.push_back({{f(n[0]), f(n[1]), f(n[2])}, f(offset_m), material, body});
  }
  return STILLGRID_OK;
}

int read_static(const stillgrid_scene& scene, publication::StaticScene& fixed) {
  if (scene.static_shapes == nullptr) return STILLGRID_OK;
  stillgrid_shapes shapes;
  if (const int code =
          take_known(scene.static_shapes, "scene.static_shapes", sizeof(stillgrid_shapes), shapes))
    return code;
  if (const int code = check_shapes(shapes, scene.material_count, true)) return code;
  for (std::size_t i = 0; i < shapes.count; ++i) {
    const double* p = shapes.positions_m + 3 * i;
    proto::SphereRecord& record = fixed.spheres.emplace_back();
    collision::fill_history(record, {{f(p[0]), f(p[1]), f(p[2])}, {}});
    record.radius_m = f(shapes.radii_m[i]);
    record.material = shapes.materials == nullptr ? 0 : shapes.materials[i];
    record.body = shapes.bodies == nullptr ? 0 : shapes.bodies[i];
  }
  return STILLGRID_OK;
}

int read_device(const stillgrid_hand& hand, std::uint32_t number, publication::StaticScene& fixed) {
  const auto& p = hand.device_position_m;
  const auto& q = hand.device_orientation_xyzw;
  const double size2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const double scale = hand.device_scale == 0.0 ? 1.0 : hand.device_scale;
  if (!is_number(p[0]) || !is_number(p[1]) || !is_number(p[2]) || !is_number(scale) ||
      !(scale > 0.0))
    return fail(STILLGRID_E_ARGUMENT,
                "scene.hands[%u]: device at (%g, %g, %g) m, scale %g: expected numbers, the scale "
                "more than 0",
                number, p[0], p[1], p[2], scale);
  if (size2 != 0.0 && !(std::abs(size2 - 1.0) < kUnit))
    return fail(STILLGRID_E_ARGUMENT,
                "scene.hands[%u].device_orientation_xyzw: (%g, %g, %g, %g): expected a unit "
                "quaternion, or zeros",
                number, q[0], q[1], q[2], q[3]);
  fixed.device.position_m = {p[0], p[1], p[2]};
  fixed.device.orientation_xyzw = {q[0], q[1], q[2], size2 == 0.0 ? 1.0 : q[3]};
  fixed.device.scale = scale;
  return STILLGRID_OK;
}

int read_hand(const stillgrid_hand& hand, std::uint32_t number, publication::HandScene& read) {
  if (hand.tool_m == nullptr || hand.tool_count == 0 || hand.tool_count > proto::kMaxToolSpheres)
    return fail(STILLGRID_E_ARGUMENT, "scene.hands[%u]: tool of %u spheres: expected 1 to %u",
                number, hand.tool_m == nullptr ? 0 : hand.tool_count, proto::kMaxToolSpheres);
  for (std::uint32_t i = 0; i < hand.tool_count; ++i) {
    const double* s = hand.tool_m + 4 * i;
    if (!is_number(s[0]) || !is_number(s[1]) || !is_number(s[2]) || !is_number(s[3]) ||
        !(f(s[3]) > 0.0F))
      return fail(STILLGRID_E_ARGUMENT,
                  "scene.hands[%u]: sphere %u of the tool at (%g, %g, %g) m, radius %g m: expected "
                  "numbers, the radius more than 0",
                  number, i, s[0], s[1], s[2], s[3]);
    read.fixed.tool.push_back({{f(s[0]), f(s[1]), f(s[2])}, f(s[3])});
  }
  if (hand.name != nullptr) {
    read.name = hand.name;
    if (const std::string complaint = publication::hand_complaint(read.name); !complaint.empty())
      return fail(STILLGRID_E_ARGUMENT, "scene.hands[%u].name: %s", number, complaint.c_str());
  }
  return read_device(hand, number, read.fixed);
}

int read_hands(const stillgrid_scene& scene, const publication::StaticScene& fixed,
               std::vector<publication::HandScene>& hands) {
  if (scene.hand_count > proto::kMaxHands || (scene.hand_count > 0 && scene.hands == nullptr))
    return fail(STILLGRID_E_ARGUMENT, "scene.hand_count: %u: expected 0 to %zu", scene.hand_count,
                proto::kMaxHands);
  hands.assign(std::max(1U, scene.hand_count), {"", fixed});
  constexpr double kBall_m[] = {0.0, 0.0, 0.0, kDefaultTool_m};
  stillgrid_hand ball{};
  ball.tool_count = 1;
  ball.tool_m = kBall_m;
  if (scene.hand_count == 0) return read_hand(ball, 0, hands.front());
  const auto* at = reinterpret_cast<const char*>(scene.hands);
  for (std::uint32_t i = 0; i < scene.hand_count; ++i) {
    stillgrid_hand hand;
    // Their own size tells where the next one stands, of a caller that knows more or fewer fields.
    const auto* given = reinterpret_cast<const stillgrid_hand*>(at);
    if (const int code = take_known(given, "scene.hands[]", sizeof(stillgrid_hand), hand))
      return code;
    if (const int code = read_hand(hand, i, hands[i])) return code;
    for (std::uint32_t other = 0; other < i; ++other)
      if (hands[other].name == hands[i].name)
        return fail(STILLGRID_E_ARGUMENT, "scene.hands[%u].name: '%s': expected a name of its own",
                    i, hands[i].name.c_str());
    at += given->struct_size;
  }
  if (scene.hand_count > 1)
    for (std::uint32_t i = 0; i < scene.hand_count; ++i)
      if (hands[i].name.empty())
        return fail(STILLGRID_E_ARGUMENT, "scene.hands[%u].name: expected a name, of several hands",
                    i);
  return STILLGRID_OK;
}

}  // namespace

int check_shapes(const stillgrid_shapes& shapes, std::uint32_t material_count,
                 bool is_static) noexcept {
  if (shapes.count == 0) return STILLGRID_OK;
  if (shapes.radii_m == nullptr || (is_static && shapes.positions_m == nullptr))
    return fail(STILLGRID_E_ARGUMENT, "shapes: %s: expected %u spheres', not null",
                shapes.radii_m == nullptr ? "radii_m" : "positions_m", shapes.count);
  if (const int code = check_positive({shapes.radii_m, shapes.count}, "shapes.radii_m"))
    return code;
  if (is_static)
    if (const int code = check_numbers({shapes.positions_m, std::size_t{shapes.count} * 3},
                                       "shapes.positions_m"))
      return code;
  for (std::uint32_t i = 0; shapes.materials != nullptr && i < shapes.count; ++i)
    if (shapes.materials[i] >= material_count)
      return fail(STILLGRID_E_ARGUMENT, "shapes.materials[%u]: %u: expected 0 to %u", i,
                  shapes.materials[i], material_count - 1);
  return STILLGRID_OK;
}

int read_scene(const stillgrid_scene& scene, publication::SessionSpec& spec,
               std::vector<publication::HandScene>& hands) {
  spec.name = scene.session == nullptr ? "default" : scene.session;
  if (spec.name.find(publication::kHandMark) != std::string::npos ||
      spec.name.find('/') != std::string::npos)
    return fail(STILLGRID_E_ARGUMENT,
                "scene.session: '%s': expected a name of 1 to 64 letters, digits, '_', '-' or '.'",
                scene.session);
  if (!(scene.period_s >= 1e-4 && scene.period_s <= kLongestPeriod_s))
    return fail(STILLGRID_E_ARGUMENT, "scene.period_s: %g: expected 0.0001 to %g", scene.period_s,
                kLongestPeriod_s);
  if (scene.clock > STILLGRID_VIRTUAL_TIME)
    return fail(STILLGRID_E_ARGUMENT,
                "scene.clock: %u: expected STILLGRID_REAL_TIME (0) or "
                "STILLGRID_VIRTUAL_TIME (1)",
                scene.clock);
  spec.clock =
      scene.clock == STILLGRID_VIRTUAL_TIME ? proto::Clock::kVirtual : proto::Clock::kMonotonic;
  spec.moving_count = scene.sphere_capacity;
  spec.period_ns = static_cast<std::uint64_t>(std::llround(scene.period_s * 1e9));
  publication::StaticScene fixed;
  if (scene.gives_inertia > 1)
    return fail(STILLGRID_E_ARGUMENT, "scene.gives_inertia: %u: expected 0 or 1",
                scene.gives_inertia);
  if (scene.name != nullptr) fixed.name = scene.name;
  if (fixed.name.size() >= sizeof(proto::SceneHeader::name))
    return fail(STILLGRID_E_ARGUMENT, "scene.name: %zu bytes: expected %zu at most",
                fixed.name.size(), sizeof(proto::SceneHeader::name) - 1);
  if (const int code = read_materials(scene, fixed)) return code;
  if (const int code = read_planes(scene, fixed)) return code;
  if (const int code = read_static(scene, fixed)) return code;
  if (const int code = read_hands(scene, fixed, hands)) return code;
  if (scene.gives_inertia == 0) return STILLGRID_OK;
  const std::vector<std::byte> model = encode(given_model(spec, hands));
  std::vector<std::string> names;
  for (const publication::HandScene& hand : hands) names.push_back(hand.name);
  for (std::size_t i = 0; i < hands.size(); ++i) {
    hands[i].fixed.model = model;
    hands[i].fixed.state_capacity = local::given_state_capacity(spec.moving_count);
    hands[i].fixed.hands = names;
    hands[i].fixed.hand = i;
  }
  return STILLGRID_OK;
}

local::GivenModel given_model(const publication::SessionSpec& spec,
                              std::span<const publication::HandScene> hands) {
  local::GivenModel model;
  model.period_ticks = (spec.period_ns + proto::kPathTick_ns - 1) / proto::kPathTick_ns;
  for (const proto::Material& m : hands.front().fixed.materials)
    model.materials.push_back(
        {m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s});
  for (const publication::HandScene& hand : hands) {
    local::GivenModel::Tool& tool = model.tools.emplace_back();
    for (const proto::ToolSphere& sphere : hand.fixed.tool)
      tool.spheres.push_back(
          {Eigen::Map<const Eigen::Vector3f>(sphere.position_m.data()).cast<double>(),
           double{sphere.radius_m}});
  }
  return model;
}

}  // namespace stillgrid::library

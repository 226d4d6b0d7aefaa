#include "haptic_server/recording/mcap_messages.hpp"

#include <algorithm>
#include <string_view>

#include "haptic_server/recording/json_text.hpp"
#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::recording {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr float kPlaneSide_m = 0.5F;
constexpr float kPlaneThickness_m = 0.0005F;

struct Colour {
  float r, g, b, a;
};
/// Which those who see few colours tell apart [Okabe, Ito, 2008]; of bodies in turn.
constexpr std::array<Colour, 6> kColours = {{{0.90F, 0.62F, 0.00F, 1.0F},
                                             {0.34F, 0.71F, 0.91F, 1.0F},
                                             {0.00F, 0.62F, 0.45F, 1.0F},
                                             {0.94F, 0.89F, 0.26F, 1.0F},
                                             {0.84F, 0.37F, 0.00F, 1.0F},
                                             {0.80F, 0.47F, 0.65F, 1.0F}}};
constexpr Colour kToolColour = {0.00F, 0.45F, 0.70F, 1.0F};
constexpr Colour kPlaneColour = {0.60F, 0.60F, 0.60F, 0.5F};

void add_time(JsonText& json, std::string_view name, std::uint64_t time_ns) {
  json.key(name).open('{').member("sec", time_ns / kSecond_ns);
  json.member("nsec", time_ns % kSecond_ns).close('}');
}

void add_quaternion(JsonText& json, std::string_view name, const Eigen::Quaterniond& q) {
  json.key(name).open('{').member("x", q.x()).member("y", q.y());
  json.member("z", q.z()).member("w", q.w()).close('}');
}

template <class Vector>
void add_shape(JsonText& json, const Vector& centre_m, const Eigen::Quaterniond& turn,
               const std::array<float, 3>& size_m, const Colour& colour) {
  json.open('{').key("pose").open('{').vector("position", centre_m);
  add_quaternion(json, "orientation", turn);
  json.close('}').vector("size", size_m);
  json.key("color").open('{').member("r", colour.r).member("g", colour.g);
  json.member("b", colour.b).member("a", colour.a).close('}').close('}');
}

template <class Vector>
void add_sphere(JsonText& json, const Vector& centre_m, float radius_m, const Colour& colour) {
  const float size_m = 2.0F * radius_m;
  add_shape(json, centre_m, Eigen::Quaterniond::Identity(), {size_m, size_m, size_m}, colour);
}

struct Entity {
  std::uint64_t time_ns;
  std::string_view frame, id, shapes;  // of one kind
  std::uint64_t left_out = 0;          // spheres of the whole scene that are not recorded
};

/// An entity with the shapes that `add` adds.
template <class Add>
void add_entity(JsonText& json, const Entity& entity, Add&& add) {
  json.open('{');
  add_time(json, "timestamp", entity.time_ns);
  json.member("frame_id", entity.frame).member("id", entity.id);
  json.key("lifetime").open('{').member("sec", 0).member("nsec", 0).close('}');  // until replaced
  json.member("frame_locked", true).key("metadata").open('[');
  if (entity.left_out > 0)
    json.open('{')
        .member("key", "spheres left out of the scene")
        .member("value", std::string_view(std::to_string(entity.left_out)))
        .close('}');
  json.close(']');
  for (const std::string_view name :
       {"arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"}) {
    json.key(name).open('[');
    if (name == entity.shapes) add();
    json.close(']');
  }
  json.close('}');
}

/// "body 3"
std::string numbered(std::string_view what, std::uint32_t number) {
  std::string name(what);
  name += ' ';
  name += std::to_string(number);
  return name;
}

/// What was shown before goes, so that each message is all that there is: a player that jumps
/// shows the last one before.
template <class Add>
void add_update(JsonText& json, std::uint64_t time_ns, Add&& add) {
  json.open('{').key("deletions").open('[').open('{');
  add_time(json, "timestamp", time_ns);
  json.member("type", 1).member("id", "").close('}').close(']');  // 1: all
  json.key("entities").open('[');
  add();
  json.close(']').close('}');
}

void add_bodies(JsonText& json, const SampledSpheres& sampled, std::uint64_t time_ns) {
  std::vector<SampledSphere> spheres = sampled.spheres;
  std::stable_sort(spheres.begin(), spheres.end(),
                   [](const auto& a, const auto& b) { return a.body < b.body; });
  for (auto first = spheres.begin(); first != spheres.end();) {
    const auto last = std::find_if(first, spheres.end(),
                                   [&](const auto& sphere) { return sphere.body != first->body; });
    const std::string id = numbered("body", first->body);
    add_entity(json, {time_ns, "scene", id, "spheres", sampled.left_out}, [&] {
      for (auto sphere = first; sphere != last; ++sphere)
        add_sphere(json, sphere->centre_m, sphere->radius_m,
                   kColours[sphere->body % kColours.size()]);
    });
    first = last;
  }
}

// Eigen's FromTwoVectors compiles a singular value decomposition.
Eigen::Quaterniond turn_from_z(const Eigen::Vector3d& normal) {
  const Eigen::Quaterniond twice(1.0 + normal.z(), -normal.y(), normal.x(), 0.0);
  return twice.norm() > 1e-9 ? twice.normalized() : Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
}

}  // namespace

void write_tick(const TickRow& row, std::string& json) {
  std::string flags;
  append_flags(row.flags, flags);
  JsonText text(json);
  text.open('{').member("time_s", row.time_s).vector("velocity_m_s", row.velocity_m_s);
  text.vector("force_N", row.force_N).vector("rendered_force_N", row.rendered_N);
  text.vector("torque_N_m", row.torque_N_m).member("snapshot_id", row.snapshot_id);
  text.member("alpha", row.alpha).member("contacts", row.contacts).member("age_s", row.age_s);
  text.member("tick_ns", row.tick_ns).member("flags", std::string_view(flags)).close('}');
}

void write_flags(std::uint32_t flags, std::string& json) {
  JsonText text(json);
  text.open('{');
  for (std::size_t i = 0; i < safety::kSafetyFlagNames.size(); ++i)
    text.member(safety::kSafetyFlagNames[i], (flags & (1U << i)) != 0);
  text.close('}');
}

void write_pose(const TickRow& row, std::uint64_t time_ns, std::string& json) {
  JsonText text(json);
  text.open('{');
  add_time(text, "timestamp", time_ns);
  text.member("parent_frame_id", "scene").member("child_frame_id", "tool");
  text.vector("translation", row.position_m);
  add_quaternion(text, "rotation", row.orientation);
  text.close('}');
}

void write_spheres(const SampledSpheres& sampled, std::uint64_t time_ns, std::string& json) {
  JsonText text(json);
  add_update(text, time_ns, [&] { add_bodies(text, sampled, time_ns); });
}

void write_fixed(const FixedScene& scene, std::uint64_t time_ns, std::string& json) {
  JsonText text(json);
  add_update(text, time_ns, [&] {
    add_bodies(text, scene.spheres, time_ns);
    for (const proto::Plane& plane : scene.planes) {
      const Eigen::Vector3d normal = Eigen::Vector3f(plane.normal.data()).cast<double>();
      const Eigen::Vector3d centre_m = normal * (plane.offset_m - 0.5F * kPlaneThickness_m);
      const Eigen::Quaterniond turn = turn_from_z(normal);
      const std::string id = numbered("plane", plane.body);
      add_entity(text, {time_ns, "scene", id, "cubes"}, [&] {
        add_shape(text, centre_m, turn, {kPlaneSide_m, kPlaneSide_m, kPlaneThickness_m},
                  kPlaneColour);
      });
    }
  });
}

void write_tool(const std::vector<proto::ToolSphere>& tool, std::uint64_t time_ns,
                std::string& json) {
  JsonText text(json);
  add_update(text, time_ns, [&] {
    add_entity(text, {time_ns, "tool", "tool", "spheres"}, [&] {
      for (const proto::ToolSphere& sphere : tool)
        add_sphere(text, sphere.position_m, sphere.radius_m, kToolColour);
    });
  });
}

}  // namespace stillgrid::recording

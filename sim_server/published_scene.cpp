#include "sim_server/published_scene.hpp"

#include "sim_server/snapshot/moving_fields.hpp"
#include "sim_server/snapshot/sphere_records.hpp"

namespace stillgrid::sim_server {
namespace {

/// In the order of World::fields, as the model's: a reader joins the two by their numbers.
std::vector<publication::PublishedField> published_fields(const bodies::World& world) {
  std::vector<publication::PublishedField> fields;
  std::uint32_t moving = 0;
  for (const bodies::FieldBody& own : world.fields) {
    publication::PublishedField& field = fields.emplace_back();
    field.field = own.field;
    field.body.rest = snapshot::state_of(world, own);
    field.body.moving = own.rigid < 0 ? 0 : ++moving;
    field.body.material = static_cast<std::uint32_t>(own.material);
    field.body.body = static_cast<std::uint32_t>(own.body);
  }
  return fields;
}

dynamics::SceneModel model_of(const scene::SceneDescription& scene, const bodies::World& world) {
  const std::vector<scene::Hand> hands = scene::hands_of(scene);
  dynamics::SceneModel model =
      dynamics::model_of(dynamics::described(world, hands, scene.sleeping), world);
  model.is_implicit = scene::is_implicit(scene.method.integrator);
  model.tolerance_m_s = scene.method.tolerance_m_s;
  return model;
}

/// A state grows as contacts are listed. Any sphere may have some, one that moves more of them.
void add_model(const dynamics::SceneModel& model, const dynamics::Simulation& simulation,
               publication::StaticScene& fixed) {
  constexpr std::size_t kBytesOfMoving = 2048, kBytesOfSphere = 256, kBytesOfScene = 65'536;
  fixed.model = dynamics::encode(model);
  std::vector<std::byte> state;
  (void)simulation.save_state(state);
  fixed.state_capacity = 2 * state.size() + kBytesOfMoving * simulation.world().spheres.size() +
                         kBytesOfSphere * model.description.spheres.size() + kBytesOfScene;
}

/// What is of one hand in the fixed part of its segment.
void set_hand(const scene::Hand& hand, std::size_t number, publication::StaticScene& fixed) {
  const auto f = [](double value) { return static_cast<float>(value); };
  fixed.tool.clear();
  for (const scene::ToolSphere& sphere : hand.tool)
    fixed.tool.push_back(
        {{f(sphere.position_m.x()), f(sphere.position_m.y()), f(sphere.position_m.z())},
         f(sphere.radius_m)});
  fixed.tool_slip_speed_m_s = f(hand.tool_slip_speed_m_s);
  if (!fixed.hands.empty()) fixed.hand = number;
  const scene::DeviceFrame& device = hand.device;
  fixed.device = {{device.position_m.x(), device.position_m.y(), device.position_m.z()},
                  {device.orientation.x(), device.orientation.y(), device.orientation.z(),
                   device.orientation.w()},
                  device.scale};
}

/// None: the scene is not stepped elsewhere.
std::optional<dynamics::SceneModel> local_model(const scene::SceneDescription& scene,
                                                const dynamics::Simulation& simulation) {
  constexpr double kRounding = 1e-6;
  if (!simulation.has_ticks() || scene.period_s < (1.0 - kRounding) * dynamics::kTick_s)
    return std::nullopt;
  dynamics::SceneModel model = model_of(scene, simulation.world());
  if (dynamics::counted_tick_ns(model) > dynamics::kLongestTick_ns) return std::nullopt;
  return model;
}

}  // namespace

publication::StaticScene static_scene(const scene::SceneDescription& scene,
                                      const dynamics::Simulation& simulation) {
  const std::vector<scene::Hand> hands = scene::hands_of(scene);
  const bodies::World& world = simulation.world();
  publication::StaticScene fixed;
  fixed.name = scene.name;
  const auto f = [](double value) { return static_cast<float>(value); };
  for (const collision::ContactMaterial& m : world.materials)
    fixed.materials.push_back(
        {f(m.stiffness_N_per_m), f(m.damping_N_s_per_m), f(m.friction), f(m.slip_speed_m_s)});
  for (const bodies::StaticPlane& plane : world.planes)
    fixed.planes.push_back({{f(plane.normal.x()), f(plane.normal.y()), f(plane.normal.z())},
                            f(plane.offset_m),
                            static_cast<std::uint32_t>(plane.material),
                            static_cast<std::uint32_t>(plane.body)});
  if (const auto model = local_model(scene, simulation)) {
    add_model(*model, simulation, fixed);
    for (const scene::Hand& hand : hands) fixed.hands.push_back(hand.name);
  }
  fixed.spheres = snapshot::static_records(world);
  fixed.fields = published_fields(world);
  set_hand(hands.front(), 0, fixed);
  return fixed;
}

std::vector<publication::HandScene> hand_scenes(const scene::SceneDescription& scene,
                                                const dynamics::Simulation& simulation) {
  publication::StaticScene fixed = static_scene(scene, simulation);
  std::vector<publication::HandScene> hands;
  for (const scene::Hand& hand : scene::hands_of(scene)) {
    set_hand(hand, hands.size(), fixed);
    hands.push_back({hand.name, fixed});
  }
  return hands;
}

std::optional<dynamics::ToolSample> sample_of(const std::optional<proto::ToolState>& state) {
  if (!state) return std::nullopt;
  const auto& [x, y, z, w] = state->orientation_xyzw;
  return dynamics::ToolSample{state->time_ns, Eigen::Vector3d(state->position_m.data()),
                              Eigen::Quaterniond(w, x, y, z),
                              Eigen::Vector3d(state->velocity_m_s.data())};
}

publication::SnapshotTimes times_of(const ScheduledSnapshot& snapshot,
                                    const dynamics::StepReport& step, std::size_t hand) {
  return {.state_ns = snapshot.state_ns,
          .publish_ns = snapshot.publish_ns,
          .tool_ns = step.tools[hand].time_ns,
          .contacts = static_cast<std::uint64_t>(step.contacts),
          .tool_work_J = step.tools[hand].work_J};
}

}  // namespace stillgrid::sim_server

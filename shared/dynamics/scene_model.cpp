#include "shared/dynamics/scene_model.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <stdexcept>
#include <string>

#include "shared/dynamics/byte_block.hpp"
#include "shared/dynamics/engine.hpp"
#include "shared/dynamics/implicit_step.hpp"
#include "shared/dynamics/spectrum_bound.hpp"

namespace stillgrid::dynamics {
namespace {

constexpr std::uint64_t kFormat = 0x33'6c65646f6d'6773;  // "sgmodel3"; counts up with the layout

class Encoder {
 public:
  explicit Encoder(std::vector<std::byte>& bytes) : writer_(bytes) {}

  template <class... Values>
  void operator()(const Values&... values) {
    (add(values), ...);
  }
  template <class T>
  void each(const std::vector<T>& items) {
    writer_.add<std::uint64_t>(items.size());
    for (const T& item : items) visit(*this, item);
  }

 private:
  template <class T>
  void add(const T& number) {
    writer_.add(number);
  }
  void add(bool is) { writer_.add<std::uint8_t>(is ? 1 : 0); }
  void add(const Eigen::Vector3d& v) { (*this)(v.x(), v.y(), v.z()); }

  BlockWriter writer_;
};

/// Bytes of an item, which are as many for each.
template <class T>
std::size_t encoded_size() {
  std::vector<std::byte> bytes;
  Encoder encoder(bytes);
  const T item{};
  visit(encoder, item);
  return bytes.size();
}

class Decoder {
 public:
  explicit Decoder(std::span<const std::byte> bytes) : reader_(bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (read(values), ...);
  }
  template <class T>
  void each(std::vector<T>& items) {
    items.resize(reader_.count(encoded_size<T>()));
    for (T& item : items) visit(*this, item);
  }
  [[nodiscard]] bool is_at_end() const { return reader_.is_at_end(); }

 private:
  template <std::integral T>
  void read(T& number) {
    number = reader_.number<T>();
  }
  void read(double& number) {
    constexpr double kLargest = 1e12;
    number = reader_.number<double>();
    if (!(std::abs(number) <= kLargest))
      throw std::invalid_argument("the model has a number that is not finite or above 1e12");
  }
  void read(bool& is) {
    const auto byte = reader_.number<std::uint8_t>();
    if (byte > 1) throw std::invalid_argument("the model has a truth value above 1");
    is = byte == 1;
  }
  void read(Eigen::Vector3d& v) { (*this)(v.x(), v.y(), v.z()); }

  BlockReader reader_;
};

// The layout: what a model consists of, in turn. One list of members serves both directions, so
// each function takes an item that is const or not.
template <class T, class Item>
concept Is = std::same_as<std::remove_const_t<T>, Item>;

void visit(auto& io, Is<Vector4> auto& v) {
  io(v.x, v.y, v.z, v.w);
}
void visit(auto& io, Is<std::uint8_t> auto& number) {
  io(number);
}
void visit(auto& io, Is<std::pair<int, int>> auto& pair) {
  io(pair.first, pair.second);
}
void visit(auto& io, Is<Description::Node> auto& node) {
  io(node.mass_kg, node.is_pinned);
}
void visit(auto& io, Is<Description::Spring> auto& spring) {
  io(spring.a, spring.b, spring.rest_length_m, spring.stiffness_N_per_m, spring.damping_N_s_per_m);
}
void visit(auto& io, Is<Description::Joint> auto& joint) {
  io(joint.a.node, joint.a.rigid, joint.a.point_m, joint.b.node, joint.b.rigid, joint.b.point_m);
  io(joint.rest_length_m, joint.stiffness_N_per_m, joint.damping_N_s_per_m);
}
void visit(auto& io, Is<Description::Rigid> auto& rigid) {
  io(rigid.mass_kg, rigid.inertia_kg_m2, rigid.is_driven, rigid.is_fixture);
}
void visit(auto& io, Is<Description::Sphere> auto& sphere) {
  io(sphere.radius_m, sphere.material, sphere.body, sphere.rigid, sphere.local_m);
  io(sphere.node_count);
  for (auto& node : sphere.nodes) io(node);
  for (auto& weight : sphere.weights) io(weight);
  io(sphere.is_tool, sphere.tool_slip_speed_m_s, sphere.is_field_point, sphere.crushing_force_N);
}
void visit(auto& io, Is<Description::Field> auto& field) {
  io(field.rigid, field.position_m, field.material, field.body);
  auto& turn = field.orientation;
  io(turn.x(), turn.y(), turn.z(), turn.w());
}
void visit(auto& io, Is<Description::Plane> auto& plane) {
  io(plane.normal, plane.offset_m, plane.material, plane.body);
}
void visit(auto& io, Is<Description::Body> auto& body) {
  io(body.first_node, body.node_count, body.rigid, body.rest_speed_m_s, body.bounding_radius_m);
}
void visit(auto& io, Is<collision::ContactMaterial> auto& material) {
  io(material.stiffness_N_per_m, material.damping_N_s_per_m, material.friction,
     material.slip_speed_m_s);
}
void visit(auto& io, Is<PrescribedMotion> auto& motion) {
  io(motion.start_m, motion.velocity_m_s, motion.direction, motion.amplitude_m,
     motion.frequency_hz);
}
/// A keyframe and the number of its motion.
struct ListedKeyframe {
  std::uint32_t motion = 0;
  Keyframe keyframe;
};
void visit(auto& io, Is<ListedKeyframe> auto& listed) {
  io(listed.motion, listed.keyframe.time_s, listed.keyframe.displacement_m);
}
void visit(auto& io, Is<Description> auto& description) {
  io(description.gravity_m_s2);
  io.each(description.nodes);
  io.each(description.springs);
  io.each(description.joints);
  io.each(description.rigid_bodies);
  io.each(description.spheres);
  io.each(description.planes);
  io.each(description.fields);
  io.each(description.bodies);
  io.each(description.materials);
  io.each(description.apart);
  io.each(description.apart_spheres);
}
void visit(auto& io, Is<SceneState> auto& state) {
  io(state.tick, state.contacts.stiffness_per_s2, state.contacts.damping_per_s);
  io.each(state.node_position_m);
  io.each(state.node_velocity_m_s);
  io.each(state.rigid_position_m);
  io.each(state.rigid_velocity_m_s);
  io.each(state.orientation);
  io.each(state.angular_velocity_rad_s);
  io.each(state.is_here);
}
void visit(auto& io, Is<SceneModel> auto& model) {
  visit(io, model.description);
  visit(io, model.start);
  io.each(model.prescribed);
  io(model.has_static_body, model.hands, model.is_implicit, model.tolerance_m_s);
}

std::vector<ListedKeyframe> list_keyframes(const SceneModel& model) {
  std::vector<ListedKeyframe> listed;
  for (std::uint32_t m = 0; m < model.prescribed.size(); ++m)
    if (const auto& keyframes = model.prescribed[m].keyframes)
      for (const Keyframe& keyframe : *keyframes) listed.push_back({m, keyframe});
  return listed;
}

void set_keyframes(const std::vector<ListedKeyframe>& listed, SceneModel& model) {
  std::vector<PrescribedMotion::Keyframes> of_motion(model.prescribed.size());
  for (const ListedKeyframe& item : listed) {
    if (item.motion >= of_motion.size())
      throw std::invalid_argument("the model has a keyframe of motion " +
                                  std::to_string(item.motion) + " of " +
                                  std::to_string(of_motion.size()));
    of_motion[item.motion].push_back(item.keyframe);
  }
  for (std::size_t m = 0; m < of_motion.size(); ++m)
    if (!of_motion[m].empty())
      model.prescribed[m].keyframes =
          std::make_shared<const PrescribedMotion::Keyframes>(std::move(of_motion[m]));
}

}  // namespace

EngineMethod SceneModel::method() const {
  return is_implicit ? implicit_euler(tolerance_m_s) : EngineMethod{};
}

std::vector<std::byte> encode(const SceneModel& model) {
  std::vector<std::byte> bytes;
  Encoder encoder(bytes);
  encoder(kFormat);
  visit(encoder, model);
  encoder.each(list_keyframes(model));
  return bytes;
}

SceneModel decode(std::span<const std::byte> bytes,
                  std::span<const std::shared_ptr<const collision::DistanceField>> distances) {
  Decoder decoder(bytes);
  std::uint64_t format = 0;
  decoder(format);
  if (format != kFormat)
    throw std::invalid_argument("the model is not of this version of the engine");
  SceneModel model;
  visit(decoder, model);
  std::vector<ListedKeyframe> listed;
  decoder.each(listed);
  set_keyframes(listed, model);
  if (!decoder.is_at_end()) throw std::invalid_argument("the model goes on behind its end");
  std::vector<Description::Field>& fields = model.description.fields;
  if (fields.size() != distances.size())
    throw std::invalid_argument("the model has " + std::to_string(fields.size()) +
                                " fields; expected " + std::to_string(distances.size()));
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i].distance = distances[i];
  validate(model);
  return model;
}

TickCounts counts_of(const Description& description) {
  const auto is_free = [&](int rigid) {
    const auto& body = description.rigid_bodies[static_cast<std::size_t>(rigid)];
    return !body.is_fixture && !body.is_driven;
  };
  const auto moves = [&](const Description::Sphere& sphere) {
    return sphere.rigid < 0 ||
           !description.rigid_bodies[static_cast<std::size_t>(sphere.rigid)].is_fixture;
  };
  double unknowns = 3.0 * static_cast<double>(description.nodes.size());
  for (std::size_t r = 0; r < description.rigid_bodies.size(); ++r)
    unknowns += is_free(static_cast<int>(r)) ? 6.0 : 0.0;
  return {.springs = static_cast<double>(description.springs.size() + description.joints.size()),
          .spheres = static_cast<double>(std::ranges::count_if(description.spheres, moves)),
          .all_spheres = static_cast<double>(description.spheres.size()),
          .unknowns = unknowns};
}

double counted_tick_ns(const TickCounts& counts, double substeps, double products,
                       double rows) noexcept {
  constexpr double kSpring_ns = 3.0, kSphere_ns = 5.0, kUnknown_ns = 8.0, kRow_ns = 300.0;
  constexpr double kShown_ns = 40.0, kPlaced_ns = 8.0;  // a sphere that moves, any: in each tick
  return substeps * (kSpring_ns * counts.springs + kSphere_ns * counts.spheres + kRow_ns * rows) +
         products * (kSpring_ns * counts.springs + kUnknown_ns * counts.unknowns + kRow_ns * rows) +
         kShown_ns * counts.spheres + kPlaced_ns * counts.all_spheres;
}

double counted_listing_ns(const TickCounts& counts, double pairs, double comparisons) noexcept {
  constexpr double kMoving_ns = 240.0, kAny_ns = 60.0, kPair_ns = 10.0, kComparison_ns = 0.15;
  return kMoving_ns * counts.spheres + kAny_ns * counts.all_spheres + kPair_ns * pairs +
         kComparison_ns * comparisons;
}

double counted_tick_ns(const SceneModel& model) {
  constexpr double kProducts = 30.0;
  const TickCounts counts = counts_of(model.description);
  if (model.is_implicit) return counted_tick_ns(counts, 1.0, kProducts, 0.0);
  JointBound joints(model.description);
  const SpectrumBound bound =
      spring_bound(model.description) + joints(model.description, model.start, 0.0);
  return counted_tick_ns(counts, stable_substeps(bound, kTick_s), 0.0, 0.0);
}

}  // namespace stillgrid::dynamics

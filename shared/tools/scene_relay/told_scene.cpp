#include "shared/tools/scene_relay/told_scene.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "shared/collision/field_history.hpp"
#include "shared/collision/sphere_history.hpp"
#include "shared/reading/snapshot.hpp"
#include "shared/tools/scene_relay/arrays.hpp"
#include "shared/tools/scene_relay/sequence.hpp"

namespace stillgrid::scene_relay {
namespace {

void require(bool is_sound, const std::string& what) {
  if (!is_sound) throw MessageError("the other side's scene is refused: " + what);
}

/// Of a material: stiffer than anything, yet of forces that are numbers.
constexpr double kLargestOfMaterial = 1e12;

/// The numbers of one of a field's arrays: `words` and from where, 4 bytes each.
template <class Number>
std::vector<Number> numbers_of(const collision::FieldView& field, std::size_t from_word,
                               std::size_t count) {
  std::vector<Number> numbers(count);
  if (count > 0) std::memcpy(numbers.data(), field.words + from_word, count * sizeof(Number));
  return numbers;
}

std::shared_ptr<const collision::DistanceField> field_of(const stillgrid_relay3_DistanceField& told,
                                                         std::uint32_t number) {
  const std::string name = "field " + std::to_string(number) + ": ";
  proto::FieldShape shape{.lowest_m = std::to_array(told.lowest_m),
                          .brick_m = told.brick_m,
                          .bricks = std::to_array(told.bricks),
                          .fine_count = 0,
                          .centre_m = std::to_array(told.centre_m),
                          .bounding_radius_m = told.bounding_radius_m,
                          .has_stiffness = told.stiffness._length != 0 ? 1U : 0U,
                          .kind = told.kind};
  require(told.fine._length % proto::kBrickCoefficients == 0, name + "half a fine brick");
  shape.fine_count = told.fine._length / proto::kBrickCoefficients;
  require(collision::is_consistent(shape), name + "a shape that none has");
  const collision::FieldCounts counts = collision::field_counts(shape);
  require(counts.coarse == told.coarse._length && counts.numbers == told.numbers._length &&
              counts.stiffness == told.stiffness._length && counts.fine == told.fine._length,
          name + "not as many numbers as its shape needs");
  const auto bricks = elements(told.numbers);
  require(are_bounded(elements(told.coarse)) && are_bounded(elements(told.stiffness)) &&
              are_bounded(elements(told.fine)) &&
              std::all_of(bricks.begin(), bricks.end(),
                          [&](std::uint32_t fine) { return fine <= shape.fine_count; }),
          name + "a number out of range");
  const collision::FieldLayout layout = collision::field_layout(shape);
  std::vector<std::uint64_t> words(layout.total_words);
  const auto put = [&](std::size_t at, const auto& sequence) {
    const auto numbers = elements(sequence);
    if (!numbers.empty()) std::memcpy(words.data() + at, numbers.data(), numbers.size_bytes());
  };
  put(layout.coarse, told.coarse);
  put(layout.numbers, told.numbers);
  put(layout.stiffness, told.stiffness);
  put(layout.fine, told.fine);
  return std::make_shared<const collision::DistanceField>(shape, std::move(words));
}

std::vector<publication::PublishedField> fields_of(const SceneMessage& message) {
  std::vector<std::shared_ptr<const collision::DistanceField>> fields;
  require(message.fields._length <= proto::kMaxFields &&
              message.field_bodies._length <= proto::kMaxFields,
          "more fields than " + std::to_string(proto::kMaxFields));
  for (const auto& told : elements(message.fields))
    fields.push_back(field_of(told, static_cast<std::uint32_t>(fields.size())));
  std::vector<publication::PublishedField> bodies;
  std::uint32_t moving = 0;
  for (const auto& told : elements(message.field_bodies)) {
    const proto::FieldState rest = state_of(told.rest);
    require(told.field < fields.size() && told.material < message.materials._length &&
                (told.moving == 0 || told.moving == ++moving) &&
                (told.moving != 0 || collision::is_sound(rest)),
            "a body's field, its order, material or place");
    proto::FieldBody body{};
    if (collision::is_sound(rest)) body.rest = rest;  // of one that moves it says nothing
    body.moving = told.moving;
    body.material = told.material;
    body.body = told.body;
    bodies.push_back({body, fields[told.field]});
  }
  return bodies;
}

std::vector<proto::SphereRecord> static_spheres_of(const SceneMessage& message) {
  require(message.spheres._length <= kMaxSpheres, "more static spheres than a relay carries");
  std::vector<proto::SphereRecord> spheres;
  spheres.reserve(message.spheres._length);
  for (const auto& told : elements(message.spheres)) {
    const auto place = std::to_array(told.position_m);
    require(are_bounded(place) && told.radius_m > 0.0F &&
                double{told.radius_m} <= proto::kLargestNumber,
            "a static sphere's place or radius");
    require(told.material < message.materials._length || told.material == proto::kFieldPoint,
            "a static sphere's material");
    proto::SphereRecord& record = spheres.emplace_back();
    collision::fill_history(record, {place, {}});
    record.radius_m = told.radius_m;
    record.material = told.material;
    record.body = told.body;
  }
  return spheres;
}

/// What a message tells of the head of a scene's fixed part; its counts were checked.
proto::SceneHeader head_of(const SceneMessage& message) {
  proto::SceneHeader head{};
  head.material_count = message.materials._length;
  head.plane_count = message.planes._length;
  head.tool_sphere_count = message.tool._length;
  head.tool_slip_speed_m_s = message.tool_slip_speed_m_s;
  head.hand_count = message.hands._length;
  head.hand = message.hand;
  head.device = {std::to_array(message.device_position_m),
                 std::to_array(message.device_orientation_xyzw), message.device_scale};
  std::size_t i = 0;
  for (const auto& m : elements(message.materials))
    head.materials[i++] = {m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s};
  i = 0;
  for (const auto& p : elements(message.planes))
    head.planes[i++] = {std::to_array(p.normal), p.offset_m, p.material, p.body};
  i = 0;
  for (const auto& h : elements(message.hands)) head.hands[i++] = std::to_array(h.name);
  i = 0;
  for (const auto& s : elements(message.tool))
    head.tool[i++] = {std::to_array(s.position_m), s.radius_m};
  return head;
}

/// What is_sound() asks to be numbers alone: what is made of them here must be some too.
bool is_bounded(const proto::SceneHeader& head) {
  bool bounded = double{head.tool_slip_speed_m_s} <= proto::kLargestNumber;
  for (const auto& [stiffness, damping, friction, slip_speed_m_s] : head.materials)
    bounded = bounded && are_bounded(std::array{stiffness, damping}, kLargestOfMaterial) &&
              are_bounded(std::array{friction, slip_speed_m_s});
  for (const proto::Plane& plane : head.planes)
    bounded = bounded && are_bounded(std::array{plane.offset_m});
  for (const proto::ToolSphere& sphere : head.tool)
    bounded = bounded && are_bounded(sphere.position_m) && are_bounded(std::array{sphere.radius_m});
  return bounded;
}

}  // namespace

ToldScene::ToldScene(const publication::SceneView& view, std::uint64_t relay_id,
                     std::uint64_t least_period_ns) {
  const proto::SceneHeader& scene = view.scene();
  message_.relay_id = relay_id;
  message_.scene_epoch = view.header().epoch;
  message_.period_ns = std::max(view.header().period_ns, least_period_ns);
  message_.moving_capacity = scene.moving_capacity;
  message_.tool_slip_speed_m_s = scene.tool_slip_speed_m_s;
  std::copy(scene.name.begin(), scene.name.end(), message_.name);
  copy(scene.device.position_m, message_.device_position_m);
  copy(scene.device.orientation_xyzw, message_.device_orientation_xyzw);
  message_.device_scale = scene.device.scale;
  for (std::uint32_t i = 0; i < scene.material_count; ++i) {
    const proto::Material& m = scene.materials[i];
    materials_.push_back({m.stiffness_N_per_m, m.damping_N_s_per_m, m.friction, m.slip_speed_m_s});
  }
  for (std::uint32_t i = 0; i < scene.plane_count; ++i) {
    const proto::Plane& p = scene.planes[i];
    planes_.push_back({{p.normal[0], p.normal[1], p.normal[2]}, p.offset_m, p.material, p.body});
  }
  for (std::uint32_t i = 0; i < scene.tool_sphere_count; ++i) {
    const auto& [place_m, radius_m] = scene.tool[i];
    tool_.push_back({{place_m[0], place_m[1], place_m[2]}, radius_m});
  }
  for (const proto::SphereRecord& record : reading::static_spheres(view, kMaxSpheres)) {
    const auto& place_m = record.newest.position_m;
    spheres_.push_back(
        {{place_m[0], place_m[1], place_m[2]}, record.radius_m, record.material, record.body});
  }
  tell_fields(view);
  tell_model(view);
  point_to(message_.materials, materials_);
  point_to(message_.planes, planes_);
  point_to(message_.tool, tool_);
  point_to(message_.spheres, spheres_);
  point_to(message_.fields, fields_);
  point_to(message_.field_bodies, bodies_);
  point_to(message_.hands, hands_);
  point_to(message_.model, model_);
}

void ToldScene::tell_fields(const publication::SceneView& view) {
  std::vector<const proto::FieldBody*> told_already;
  for (std::size_t i = 0; i < view.fields().size(); ++i) {
    const publication::SceneField& field = view.fields()[i];
    const proto::FieldState& rest = view.scene().fields[i].rest;  // to the bit as it was written
    const auto known = std::ranges::find_if(told_already, [&](const proto::FieldBody* other) {
      return publication::is_same_field(*other, field.body);
    });
    stillgrid_relay3_FieldBody body{};
    body.field = static_cast<std::uint32_t>(known - told_already.begin());
    body.moving = field.body.moving;
    body.material = field.body.material;
    body.body = field.body.body;
    body.rest = told(rest);
    bodies_.push_back(body);
    if (known != told_already.end()) continue;
    told_already.push_back(&field.body);
    const proto::FieldShape& shape = field.body.shape;
    const collision::FieldCounts counts = collision::field_counts(shape);
    const collision::FieldLayout& at = field.field.layout;
    numbers_.push_back({numbers_of<float>(field.field, at.coarse, counts.coarse),
                        numbers_of<float>(field.field, at.stiffness, counts.stiffness),
                        numbers_of<float>(field.field, at.fine, counts.fine),
                        numbers_of<std::uint32_t>(field.field, at.numbers, counts.numbers)});
    stillgrid_relay3_DistanceField& message = fields_.emplace_back();
    copy(shape.lowest_m, message.lowest_m);
    message.brick_m = shape.brick_m;
    copy(shape.bricks, message.bricks);
    copy(shape.centre_m, message.centre_m);
    message.bounding_radius_m = shape.bounding_radius_m;
    message.kind = shape.kind;
  }
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    point_to(fields_[i].coarse, numbers_[i].coarse);
    point_to(fields_[i].numbers, numbers_[i].numbers);
    point_to(fields_[i].stiffness, numbers_[i].stiffness);
    point_to(fields_[i].fine, numbers_[i].fine);
  }
}

void ToldScene::tell_model(const publication::SceneView& view) {
  const proto::SceneHeader& scene = view.scene();
  message_.hand = scene.hand;
  for (std::uint32_t i = 0; i < scene.hand_count; ++i)
    copy(scene.hands[i], hands_.emplace_back().name);
  const std::span<const std::byte> model = view.model();
  const bool is_told = scene.hand_count <= 1 && !model.empty() && model.size() <= kMaxModel_bytes &&
                       scene.state_capacity <= kMaxModel_bytes;
  if (!is_told) return;
  model_.resize(model.size());
  std::memcpy(model_.data(), model.data(), model.size());
  message_.state_capacity = scene.state_capacity;
}

publication::StaticScene scene_of(const SceneMessage& message) {
  require(message.materials._length <= proto::kMaxMaterials &&
              message.planes._length <= proto::kMaxPlanes &&
              message.tool._length <= proto::kMaxToolSpheres &&
              message.hands._length <= proto::kMaxHands,
          "more materials, planes, tool spheres or hands than there may be");
  require(message.model._length <= kMaxModel_bytes && message.state_capacity <= kMaxModel_bytes &&
              (message.model._length == 0) == (message.state_capacity == 0),
          "the size of its model or of its states");
  require(message.moving_capacity <= kMaxSpheres, "more moving spheres than a relay carries");
  require(message.period_ns >= 10'000 && message.period_ns <= 100'000'000'000,
          "a period that is none from 0.01 ms to 100 s");
  const proto::SceneHeader head = head_of(message);
  require(publication::is_sound(head) && is_bounded(head), "a count or number out of range");
  publication::StaticScene scene;
  const auto* const name_end = std::find(std::begin(message.name), std::end(message.name), '\0');
  scene.name.assign(std::begin(message.name), name_end);
  scene.materials.assign(head.materials.begin(), head.materials.begin() + head.material_count);
  scene.planes.assign(head.planes.begin(), head.planes.begin() + head.plane_count);
  scene.tool.assign(head.tool.begin(), head.tool.begin() + head.tool_sphere_count);
  scene.spheres = static_spheres_of(message);
  scene.fields = fields_of(message);
  scene.device = head.device;
  scene.tool_slip_speed_m_s = message.tool_slip_speed_m_s;
  for (const auto& hand : elements(message.hands)) scene.hands.emplace_back(hand.name);
  scene.hand = message.hand;
  const auto model = std::as_bytes(elements(message.model));
  scene.model.assign(model.begin(), model.end());
  scene.state_capacity = message.state_capacity;
  return scene;
}

}  // namespace stillgrid::scene_relay

#include "shared/publication/published_fields.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "shared/collision/field_history.hpp"
#include "shared/double_buffer/double_buffer.hpp"
#include "shared/publication/segment_files.hpp"

namespace stillgrid::publication {
namespace {

std::size_t to_line(std::size_t bytes) {
  return (bytes + 63) / 64 * 64;
}

void make_unit(std::array<float, 4>& quaternion) {
  double norm2 = 0.0;
  for (const float x : quaternion) norm2 += double{x} * double{x};
  for (float& x : quaternion) x = static_cast<float>(double{x} / std::sqrt(norm2));
}

}  // namespace

bool is_same_field(const proto::FieldBody& a, const proto::FieldBody& b) noexcept {
  return a.offset == b.offset && std::memcmp(&a.shape, &b.shape, sizeof a.shape) == 0;
}

FieldPlaces place_fields(std::span<const PublishedField> fields, std::size_t from_bytes) {
  assert(fields.size() <= proto::kMaxFields);
  FieldPlaces places{.bodies = {}, .end_bytes = from_bytes};
  for (const PublishedField& field : fields) {
    assert(field.field && (field.body.moving == 0 || field.body.moving == places.moving_count + 1));
    proto::FieldBody& body = places.bodies.emplace_back(field.body);
    places.moving_count += body.moving != 0 ? 1 : 0;
    body.shape = field.field->shape();
    const auto same = std::find_if(fields.begin(), fields.end(),
                                   [&](const auto& other) { return other.field == field.field; });
    const auto first = static_cast<std::size_t>(same - fields.begin());
    if (first + 1 < places.bodies.size()) {
      body.offset = places.bodies[first].offset;
    } else {
      body.offset = to_line(places.end_bytes);
      places.end_bytes = static_cast<std::size_t>(body.offset) + field.field->bytes();
    }
  }
  return places;
}

void write_fields(std::span<const PublishedField> fields, const FieldPlaces& places,
                  std::byte* segment) {
  for (std::size_t i = 0; i < fields.size(); ++i)
    std::ranges::copy(std::as_bytes(fields[i].field->words()), segment + places.bodies[i].offset);
}

std::vector<SceneField> read_fields(const proto::SceneHeader& scene, const std::byte* segment,
                                    std::size_t from_bytes, std::size_t end_bytes) {
  const auto require = [](bool is_sound, std::uint32_t field, const char* what) {
    if (!is_sound)
      throw SegmentError("the scene segment is refused: its field " + std::to_string(field) + " " +
                         what);
  };
  if (scene.field_count > proto::kMaxFields)
    throw SegmentError("the scene segment is refused: it counts " +
                       std::to_string(scene.field_count) + " fields, more than " +
                       std::to_string(proto::kMaxFields));
  std::vector<SceneField> fields;
  std::uint32_t moving_count = 0;
  for (std::uint32_t i = 0; i < scene.field_count; ++i) {
    SceneField& field = fields.emplace_back(SceneField{scene.fields[i], {}});
    proto::FieldBody& body = field.body;
    require(collision::is_consistent(body.shape), i, "has a shape that none has");
    require(body.material < scene.material_count, i, "names a material that there is not");
    require(body.moving == 0 || body.moving == ++moving_count, i, "is out of order");
    require(body.moving != 0 || collision::is_sound(body.rest), i, "is at no place");
    if (body.moving == 0) make_unit(body.rest.orientation_xyzw);
    field.field.shape = body.shape;
    field.field.layout = collision::field_layout(body.shape);
    require(body.offset % 64 == 0 && body.offset >= from_bytes && body.offset <= end_bytes &&
                field.field.layout.total_words <= (end_bytes - body.offset) / 8,
            i, "does not fit");
    field.field.words = reinterpret_cast<const std::uint64_t*>(segment + body.offset);
  }
  return fields;
}

std::vector<std::shared_ptr<const collision::DistanceField>> copy_fields(
    std::span<const SceneField> fields, std::size_t max_bytes) {
  std::vector<std::shared_ptr<const collision::DistanceField>> copies;
  std::size_t left_words = max_bytes / 8;
  for (const SceneField& field : fields) {
    const auto same = std::ranges::find_if(fields.first(copies.size()), [&](const auto& other) {
      return is_same_field(other.body, field.body);
    });
    if (same != fields.begin() + std::ssize(copies)) {
      copies.push_back(copies[static_cast<std::size_t>(same - fields.begin())]);
      continue;
    }
    const std::size_t count = field.field.layout.total_words;
    if (count > left_words) throw SegmentError("the scene segment is refused: its fields overlap");
    left_words -= count;
    std::vector<std::uint64_t> words(count);
    for (std::size_t i = 0; i < count; ++i)
      words[i] = double_buffer::load_word(field.field.words, i);
    copies.push_back(
        std::make_shared<const collision::DistanceField>(field.body.shape, std::move(words)));
  }
  return copies;
}

}  // namespace stillgrid::publication

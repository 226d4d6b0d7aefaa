#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/scene_segment.hpp"
#include "shared/collision/distance_field.hpp"

namespace stillgrid::publication {

/// A body that is met through its distance field, as a simulation publishes it once.
///
/// The writer fills shape and offset of `body`. The first that moves has moving = 1, the
/// next 2, and so on.
struct PublishedField {
  proto::FieldBody body{};
  std::shared_ptr<const collision::DistanceField> field;  // bodies may share one
};

/// The same as a reader has it: every number checked, a rest that is a unit quaternion.
struct SceneField {
  proto::FieldBody body{};
  collision::FieldView field;  // its words in the segment
};

/// Whether two bodies of one segment share a field: closed forms all have no numbers at one place.
[[nodiscard]] bool is_same_field(const proto::FieldBody& a, const proto::FieldBody& b) noexcept;

/// Places of fields in a segment. Bodies may share one.
struct FieldPlaces {
  std::vector<proto::FieldBody> bodies;
  std::size_t end_bytes = 0;
  std::size_t moving_count = 0;
};
/// Pre: fields.size() <= kMaxFields, moving ones in order.
[[nodiscard]] FieldPlaces place_fields(std::span<const PublishedField> fields,
                                       std::size_t from_bytes);

/// Copies their numbers to where they stand. segment: its start.
void write_fields(std::span<const PublishedField> fields, const FieldPlaces& places,
                  std::byte* segment);

/// The fields of a fixed part whose words end at end_bytes and hold no field before from_bytes.
/// Throws SegmentError unless every count, number and place is sound. segment: its start.
[[nodiscard]] std::vector<SceneField> read_fields(const proto::SceneHeader& scene,
                                                  const std::byte* segment, std::size_t from_bytes,
                                                  std::size_t end_bytes);

/// Copies of the fields in memory of their own, in their order: one for all bodies that share it.
/// Throws SegmentError where they take more than max_bytes: those of one segment do not overlap,
/// so all take less than it does. Pre: the fields are of read_fields().
[[nodiscard]] std::vector<std::shared_ptr<const collision::DistanceField>> copy_fields(
    std::span<const SceneField> fields, std::size_t max_bytes);

}  // namespace stillgrid::publication

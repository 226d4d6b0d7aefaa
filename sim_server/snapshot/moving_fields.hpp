#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "proto/distance_field.hpp"
#include "sim_server/bodies/sphere_motion.hpp"
#include "sim_server/bodies/world.hpp"

namespace stillgrid::snapshot {

/// Where a field's frame is and how it moves, as it is published: in floats.
[[nodiscard]] proto::FieldState state_of(const bodies::World& world,
                                         const bodies::FieldBody& field) noexcept;

/// The records of all moving fields, ready to publish, in the order of World::fields. Nothing is
/// allocated after construction. Thread: one.
class MovingFields {
 public:
  MovingFields() = default;
  /// Shows them where they are, as if they had been there in every snapshot before.
  explicit MovingFields(const bodies::World& world);

  /// One more snapshot: each moves on as it does, and gives no way.
  void show(const bodies::World& world) noexcept;

  /// Adds to the snapshot shown last where fields will go, as World::fields. is_predicted: tells of
  /// which this is known; others go on as they move.
  template <class IsPredicted>
  void take_predictions(std::span<const bodies::FieldPrediction> predictions,
                        const IsPredicted& is_predicted) noexcept {
    for (std::size_t i = 0; i < fields_.size(); ++i)
      if (is_predicted(fields_[i])) take(predictions[fields_[i]], records_[i]);
  }

  /// All of the snapshot shown last go on as they move.
  void forget_predictions() noexcept;

  [[nodiscard]] std::span<const proto::FieldRecord> records() const noexcept { return records_; }

 private:
  static void take(const bodies::FieldPrediction& prediction, proto::FieldRecord& record) noexcept;

  std::vector<std::size_t> fields_;  // of each record: of World::fields
  std::vector<proto::FieldRecord> records_;
};

}  // namespace stillgrid::snapshot

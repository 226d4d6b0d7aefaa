#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "proto/distance_field.hpp"
#include "shared/collision/field_history.hpp"

namespace stillgrid::publication {

/// Returns where a field's frame is and how it moves, as it is published: in floats. Realtime: yes.
[[nodiscard]] proto::FieldState field_state(const Eigen::Vector3d& position_m,
                                            const Eigen::Quaterniond& orientation,
                                            const Eigen::Vector3d& velocity_m_s,
                                            const Eigen::Vector3d& angular_velocity_rad_s) noexcept;

/// The records of all moving fields of a scene, in the scene's order. Thread: one. Realtime: yes,
/// but for construction.
class MovingFields {
 public:
  MovingFields() = default;
  /// fields: numbers of the moving ones among the scene's fields, ascending.
  explicit MovingFields(std::vector<std::size_t> fields)
      : fields_(std::move(fields)), records_(fields_.size()) {}

  /// One more snapshot. The first one shows them as if they had been there before. state_of:
  /// returns a field's state by its number.
  template <class StateOf>
  void show(const StateOf& state_of) noexcept {
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (is_first_)
        collision::fill_history(records_[i], state_of(fields_[i]));
      else
        collision::push_snapshot(records_[i], state_of(fields_[i]));
    }
    is_first_ = false;
  }

  /// Numbers of the fields that the records are of.
  [[nodiscard]] std::span<const std::size_t> fields() const noexcept { return fields_; }
  [[nodiscard]] std::span<const proto::FieldRecord> records() const noexcept { return records_; }

 private:
  std::vector<std::size_t> fields_;
  std::vector<proto::FieldRecord> records_;
  bool is_first_ = true;
};

}  // namespace stillgrid::publication

#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "proto/distance_field.hpp"

namespace stillgrid::collision {

/// Offsets of a field's arrays in its block of 8-byte words.
struct FieldLayout {
  std::size_t coarse = 0;     // f32, of bricks and a layer round them
  std::size_t numbers = 0;    // u32, of bricks
  std::size_t stiffness = 0;  // f32, as coarse
  std::size_t fine = 0;       // f32
  std::size_t total_words = 0;
};
/// How many numbers each of them holds.
struct FieldCounts {
  std::size_t coarse = 0, numbers = 0, stiffness = 0, fine = 0;
};
/// Pre: is_consistent(shape).
[[nodiscard]] FieldCounts field_counts(const proto::FieldShape& shape) noexcept;
/// Pre: is_consistent(shape).
[[nodiscard]] FieldLayout field_layout(const proto::FieldShape& shape) noexcept;

/// Whether a shape is one of a field that may be: of sizes that are bounded, and numbers that are
/// some. Realtime: yes.
[[nodiscard]] bool is_consistent(const proto::FieldShape& shape) noexcept;

/// Returns the length of the finest detail, in m: the edge of a fine cell, or half of the least
/// thickness of a closed form. Realtime: yes.
[[nodiscard]] double detail_m(const proto::FieldShape& shape) noexcept;

/// A field to read, in private memory or in a segment. Pre: is_consistent(shape), and behind
/// `words` is room for its layout.
struct FieldView {
  proto::FieldShape shape{};
  FieldLayout layout{};
  const std::uint64_t* words = nullptr;
};

/// A field at one point. Body frame.
struct FieldSample {
  double distance_m = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // exactly its derivative
  double stiffness_scale = 1.0;                        // of the map, over the material's
  Eigen::Vector3d stiffness_gradient_per_m = Eigen::Vector3d::Zero();
};

/// The field at a point, or nothing where the point lies off its bricks (NaN does). A closed form
/// has a distance everywhere (exact_shape.hpp).
///
/// A sampled field is a quadratic B-spline of 27 coefficients, in the narrow band round the surface
/// of fine ones, elsewhere of coarse ones, of which the fine ones are a refinement where the two
/// meet: value and gradient are continuous everywhere. Realtime: yes; safe on words that change or
/// lie, for which the sample is any.
[[nodiscard]] std::optional<FieldSample> sample(const FieldView& field,
                                                const Eigen::Vector3d& point_m) noexcept;

/// How a sphere meets a solid by its field, for one N/m of the material's stiffness.
///
/// The spring's energy is stiffness_scale(x) (radius - distance(x))^2 / 2 at the sphere's centre x;
/// the force is minus its gradient, so it works nothing over any closed way.
struct FieldContact {
  double depth_m = 0.0;                               // positive: an overlap
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // towards the sphere
  double stiffness_scale = 0.0;                       // so that force = k scale depth normal
  double map_scale = 1.0;  // of the map: the spring's energy is k map_scale depth^2 / 2
};

/// Nothing where the sphere's centre is off the field's bricks or the field has no direction, or
/// where a sample is no field's: steeper than a distance can be, or longer than its ball.
/// Without overlap the depth is minus the distance between the two. Body frame.
/// Realtime: yes.
[[nodiscard]] std::optional<FieldContact> field_contact(const FieldView& field,
                                                        const Eigen::Vector3d& centre_m,
                                                        double radius_m) noexcept;

/// Whether the field is flat at a contact, as in a bore, whose middle is equally far from all
/// sides: its slope is below 0.9.
[[nodiscard]] inline bool is_flat(const FieldContact& contact) noexcept {
  return contact.stiffness_scale <= 0.9 * contact.map_scale;
}

/// Returns the contact of a proxy where the field is flat. at_proxy: field_contact() there. The
/// contact at device_m counts if the field is steeper there and the face is the same. The depth is
/// corrected by the field's value at the foot of the centre, where cells are finest. Takes two
/// samples. Realtime: yes.
[[nodiscard]] FieldContact flat_contact(const FieldView& field, const FieldContact& at_proxy,
                                        const Eigen::Vector3d& proxy_m,
                                        const Eigen::Vector3d& device_m, double radius_m) noexcept;

/// A field in memory of its own.
class DistanceField {
 public:
  /// Pre: is_consistent(shape), words.size() is its layout's.
  explicit DistanceField(const proto::FieldShape& shape, std::vector<std::uint64_t> words = {});
  [[nodiscard]] FieldView view() const noexcept { return {shape_, layout_, words_.data()}; }
  [[nodiscard]] const proto::FieldShape& shape() const noexcept { return shape_; }
  [[nodiscard]] std::span<const std::uint64_t> words() const noexcept { return words_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return words_.size() * 8; }

 private:
  proto::FieldShape shape_;
  FieldLayout layout_;
  std::vector<std::uint64_t> words_;
};

/// Most bytes that a field may take.
inline constexpr std::size_t kMaxFieldBytes = std::size_t{1} << 28U;

/// How fine a field is.
struct FieldFineness {
  double cell_m = 0.0;    // edge of a fine cell
  double band_m = 0.0;    // how far from the surface, on either side, cells are fine
  double margin_m = 0.0;  // how far outside of the solid's box the field reaches at least
};

/// A function of place, body frame.
using ScalarField = std::function<double(const Eigen::Vector3d&)>;

/// Samples a signed distance (negative inside) of a solid that a box holds. stiffness_scale: a map
/// of positive numbers, sampled once a brick; none: even. Throws std::invalid_argument where the
/// field would take more than kMaxFieldBytes, or a number is none. Pre: all of `fineness` > 0.
[[nodiscard]] DistanceField make_field(const Eigen::AlignedBox3d& solid_m,
                                       const FieldFineness& fineness,
                                       const ScalarField& signed_distance_m,
                                       const ScalarField& stiffness_scale = {});

}  // namespace stillgrid::collision

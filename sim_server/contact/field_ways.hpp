#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/collision/voxel_grid.hpp"
#include "sim_server/bodies/world.hpp"
#include "sim_server/contact/contact.hpp"
#include "sim_server/contact/contact_making.hpp"
#include "sim_server/contact/field_touch.hpp"

namespace stillgrid::contact {

/// How a field may move within a step, and what it may so meet.
struct FieldWay {
  FieldPose start;
  collision::SweptBound ball;  // holds the solid wherever it goes
  double travel_m = 0.0;       // no point of the solid gets farther than this from where it was
  bool is_free = false;        // not prescribed, and not static
  bool moves = false;          // neither sleeping nor static, nor prescribed to stay
};

/// The ways of all fields of a world. Fields are few: they stand outside of grids, and are gone
/// through one after another, as planes are.
class FieldWays {
 public:
  explicit FieldWays(std::size_t count) : ways_(count) {}

  /// How each may move within step_s.
  void take(const bodies::World& world, double step_s);
  [[nodiscard]] const FieldWay& operator[](std::size_t field) const { return ways_[field]; }
  [[nodiscard]] std::size_t size() const noexcept { return ways_.size(); }
  [[nodiscard]] auto begin() const noexcept { return ways_.begin(); }
  [[nodiscard]] auto end() const noexcept { return ways_.end(); }

  /// Whether a ball may meet the field within the step.
  [[nodiscard]] bool may_meet(const bodies::World& world, std::size_t field,
                              const collision::SweptBound& ball) const {
    return may_meet(world, field, ways_[field], ball);
  }
  /// Likewise, were the field on that way.
  [[nodiscard]] static bool may_meet(const bodies::World& world, std::size_t field,
                                     const FieldWay& way, const collision::SweptBound& ball);

  // What a field may touch within a step, appended to `contacts`.

  /// A moving sphere. Pre: it may_meet().
  void add_sphere(const bodies::World& world, std::size_t field, const Mover& mover,
                  std::vector<Contact>& contacts) const;
  /// Static spheres, ascending. met: scratch.
  void add_static(const bodies::World& world, std::size_t field,
                  const collision::VoxelGrid& static_grid, std::vector<std::uint32_t>& met,
                  std::vector<Contact>& contacts) const;
  /// A sphere of the tool, which is number `number` of it and has that bound, if they may meet.
  void add_tool(const bodies::World& world, std::size_t field, const ToolSphereMotion& sphere,
                const collision::SweptBound& bound, int number,
                std::vector<Contact>& contacts) const;

 private:
  std::vector<FieldWay> ways_;
};

}  // namespace stillgrid::contact

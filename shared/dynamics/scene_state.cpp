#include "shared/dynamics/scene_state.hpp"

#include <array>
#include <bit>
#include <cstddef>

namespace stillgrid::dynamics {
namespace {

/// Each word changes a lane one to one. Four lanes hide the time that a multiplication takes.
class Lanes {
 public:
  void add(std::size_t lane, std::uint64_t word) {
    std::uint64_t& value = values_[lane];
    value = (value ^ word) * 0x9e3779b97f4a7c15;
    value ^= value >> 29;  // high bits count, too: those of signs
  }
  void add(const std::vector<Vector4>& values) {
    for (const Vector4& v : values) {
      add(0, std::bit_cast<std::uint64_t>(v.x));
      add(1, std::bit_cast<std::uint64_t>(v.y));
      add(2, std::bit_cast<std::uint64_t>(v.z));
      add(3, std::bit_cast<std::uint64_t>(v.w));
    }
  }
  [[nodiscard]] std::uint64_t value() {
    for (std::size_t lane = 1; lane < values_.size(); ++lane) add(0, values_[lane]);
    return values_[0];
  }

 private:
  std::array<std::uint64_t, 4> values_{1, 2, 3, 4};
};

}  // namespace

std::uint64_t hash(const SceneState& state) {
  Lanes lanes;
  lanes.add(0, state.tick);
  for (const std::vector<Vector4>* values : state.vectors()) lanes.add(*values);
  std::size_t lane = 0;
  for (const std::uint8_t is_here : state.is_here) lanes.add(lane++ % 4, is_here);
  return lanes.value();
}

}  // namespace stillgrid::dynamics

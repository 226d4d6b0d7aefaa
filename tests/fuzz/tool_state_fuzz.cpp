#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "shared/publication/tool_segment.hpp"
#include "sim_server/dynamics/step/simulation.hpp"
#include "tests/fuzz/hostile_object.hpp"
#include "tests/fuzz/patch.hpp"
#include "tests/fuzz/valid_segment.hpp"
#include "tests/sim_server/scene_builders.hpp"

/// The words of a tool segment: whatever the simulation takes for a sample of the tool, its world
/// stays one of numbers.
///
/// Input: for each of at most three steps flags u8 (1: the state that stands in the slot is kept
/// from the step before; 2: both slots' sequences are made sound again), patches. A hash of the
/// input says whether it is simulated too: steps cost far more than reads, and under a fuzzer the
/// checks of the reads shall get most of the inputs.
namespace stillgrid::fuzz {
namespace {

enum Flag : unsigned { kKept = 1, kSequenced = 2 };
constexpr int kMaxSteps = 3;
constexpr double kStep_s = 0.02;

std::size_t simulated_one_of = 1;  // inputs; in a replay all of them

bool is_simulated(std::string_view input) {
  return std::hash<std::string_view>{}(input) % simulated_one_of == 0;
}

class HostileTool {
 public:
  HostileTool() { object_.remove_name(); }

  void restore() { std::copy(valid_.begin(), valid_.end(), object_.bytes().begin()); }

  void spoil(FuzzInput& input) {
    const unsigned flags = input.take<std::uint8_t>();
    if ((flags & kKept) == 0) restore();
    apply_patches(parts_, input);
    if ((flags & kSequenced) == 0) return;
    auto& latest = *reinterpret_cast<std::uint64_t*>(parts_[0].data());
    latest = 2;
    *reinterpret_cast<std::uint64_t*>(parts_[1].data()) = 4;
  }

  /// What the simulation would take of the path.
  void check_path() const {
    const publication::PathView path = view_.path();
    const auto newest = path.newest();
    for (const std::uint64_t n : {newest.value_or(0), std::uint64_t{1}, std::uint64_t{2}})
      if (const auto sample = path.sample(n))
        require(sample->number == n && publication::is_sound(*sample),
                "a sample of the path that is taken is sound");
  }

  [[nodiscard]] std::optional<dynamics::ToolSample> sample() const {
    const auto state = view_.read();
    if (!state) return std::nullopt;
    for (const auto& numbers : {state->position_m, state->velocity_m_s, state->force_N})
      for (const double number : numbers)
        require(std::abs(number) <= proto::kLargestNumber, "a state that is taken is plausible");
    const auto& [x, y, z, w] = state->orientation_xyzw;
    require(std::abs(std::hypot(std::hypot(x, y), std::hypot(z, w)) - 1.0) < 1e-3,
            "a state that is taken has an orientation");
    return dynamics::ToolSample{state->time_ns, Eigen::Vector3d(state->position_m.data()),
                                Eigen::Quaterniond(w, x, y, z),
                                Eigen::Vector3d(state->velocity_m_s.data())};
  }

 private:
  std::vector<std::byte> valid_ = valid_tool();
  HostileObject object_{proto::SegmentKind::kTool, valid_};
  std::vector<std::span<std::byte>> parts_ = changing_parts(object_.bytes());
  publication::ToolView view_{*publication::SegmentReader::open(
      HostileObject::session(), proto::SegmentKind::kTool, proto::kToolLayoutHash)};
  std::vector<std::unique_ptr<ForbiddenBytes>> gaps_ = forbid_gaps(view_.reader().bytes(), valid_);
};

/// A ball and a thread within the tool's reach, above a floor.
scene::SceneDescription small_scene() {
  scene::SceneDescription scene = sim_server::scene_of(
      {sim_server::sphere({0.0, 0.0, 0.0}, 0.01, 0.05), sim_server::floor_at(-0.012),
       sim_server::thread(3, {-0.02, 0.015, 0.01}, {0.02, 0.015, 0.01}, 0.005, 100.0, {0})},
      sim_server::material_of(500.0, 1.0, 0.3), {0.0, 0.0, -9.81});
  scene.tool = {{{0.0, 0.0, 0.0}, 0.015}};
  return scene;
}

void require_numbers(const bodies::World& world) {
  for (const bodies::Node& node : world.nodes)
    require(node.position_m.allFinite() && node.velocity_m_s.allFinite(),
            "a node is somewhere, whatever the tool's state says");
  for (const bodies::RigidBody& body : world.rigid_bodies)
    require(body.position_m.allFinite() && body.velocity_m_s.allFinite() &&
                body.orientation.coeffs().allFinite() && body.angular_velocity_rad_s.allFinite(),
            "a body is somewhere, whatever the tool's state says");
}

}  // namespace
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {  // a replay does not call it
  simulated_one_of = 16;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static HostileTool tool;
  static const scene::SceneDescription scene = small_scene();
  FuzzInput input({data, size});
  tool.restore();
  std::optional<dynamics::Simulation> simulation;
  if (is_simulated({reinterpret_cast<const char*>(data), size})) simulation.emplace(scene);
  for (int i = 0; i < kMaxSteps && (i == 0 || !input.is_empty()); ++i) {
    tool.spoil(input);
    tool.check_path();
    const std::optional<dynamics::ToolSample> sample = tool.sample();
    if (!simulation || !sample) continue;
    simulation->step(kStep_s, [&] { return sample; });
    require_numbers(simulation->world());
  }
  return 0;
}

}  // namespace stillgrid::fuzz

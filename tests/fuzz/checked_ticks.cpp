#include "tests/fuzz/checked_ticks.hpp"

#include <cmath>
#include <utility>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::fuzz {
namespace {

Eigen::Vector3d take_vector(FuzzInput& input, bool is_wild, double unit) {
  Eigen::Vector3d v;
  for (double& x : v)
    x = is_wild ? input.take<double>() : unit * static_cast<double>(input.take<std::int16_t>());
  return v;
}

/// Near the spheres, or any numbers at all: a hostile device frame can lead there.
rendering::ToolPose take_pose(FuzzInput& input) {
  const auto flags = input.take<std::uint8_t>();
  rendering::ToolPose pose;
  pose.position_m = take_vector(input, (flags & 1U) != 0, 1e-5);
  pose.velocity_m_s = take_vector(input, (flags & 2U) != 0, 1e-3);
  const double angle = static_cast<double>(flags >> 2U) * 0.1;
  pose.orientation = Eigen::AngleAxisd(angle, Eigen::Vector3d(0.6, 0.0, 0.8));
  return pose;
}

void check_visits(const collision::GridView& grid, const collision::SweptBound& probe,
                  std::uint32_t max_visits) {
  std::uint32_t visits = 0;
  collision::for_each_candidate(grid, probe, max_visits, [&](std::uint32_t sphere) {
    require(sphere < grid.shape.sphere_count, "a query visits spheres of its grid");
    ++visits;
  });
  require(visits <= max_visits, "a query visits no more than it may");
}

void check_queries(const publication::SceneView& scene, const rendering::ToolPose& pose,
                   std::uint32_t max_visits) {
  const collision::SweptBound probe = collision::bound_sphere(pose.position_m, 0.02);
  check_visits(scene.static_grid(), probe, max_visits);
  std::uint32_t touches = 0;
  const std::uint32_t spheres = scene.static_grid().shape.sphere_count;
  scene.touch_lists().for_each_touch(probe, max_visits, [&](const collision::TouchEntry& entry) {
    require(entry.label.number < spheres, "a touch list names spheres of the static grid");
    ++touches;
  });
  require(touches <= max_visits, "a look into touch lists visits no more than it may");
  for (const std::uint64_t* payload : scene.buffer().payload) {
    if (scene.header().payload_bytes < sizeof(proto::SnapshotHeader)) continue;
    const auto snapshot = publication::load_snapshot(payload);
    check_visits(scene.moving_grid(payload, snapshot), probe, max_visits);
  }
}

}  // namespace

CheckedTicks::CheckedTicks() {
  const safety::SafetyLimits limits{.max_force_N = kMaxForce_N,
                                    .lever_m = kLever_m,
                                    .stiffness_N_per_m = 1000.0,
                                    .continuous_force_N = 0.9,
                                    .max_speed_m_s = 2.0};
  safety::SafetyLimits slewed = limits;
  slewed.max_slew_N_per_ms = kMaxSlew_N_per_ms;
  const auto add = [&](std::unique_ptr<rendering::Renderer> renderer) {
    const safety::SafetyLimits& own = renderings_.size() == kSlewed ? slewed : limits;
    renderings_.push_back({std::move(renderer), safety::SafetyChain(own)});
    // Past the ramp at the start, which would hide the limits.
    std::uint32_t flags = 0;
    for (int i = 0; i < 3; ++i)
      static_cast<void>(renderings_.back().safety.apply(
          {.snapshot = {.exists = true, .period_s = 1.0, .writer_alive = true}, .elapsed_s = 0.04},
          flags));
  };
  for (const display::TransitionLaw& law : display::transitions())
    add(rendering::make_renderer(law.transition));
  for (const laboratory::Rival& rival : laboratory::rivals()) add(rival.make());
}

void CheckedTicks::tick(const publication::SceneView& scene, FuzzInput& input) {
  const auto flags = input.take<std::uint8_t>();
  now_ns_ =
      (flags & 1U) != 0 ? input.take<std::uint64_t>() : now_ns_ + 1'000'000ULL * (flags >> 4U);
  const rendering::ToolPose pose = take_pose(input);
  render(scene, pose, input);
  check_queries(scene, pose, input.take<std::uint16_t>());
}

void CheckedTicks::render(const publication::SceneView& scene, const rendering::ToolPose& pose,
                          FuzzInput& input) {
  const auto state = input.take<std::uint8_t>();
  const bool writer_alive = state % 4 != 0;
  const double elapsed_s = 1e-3 * (state / 4);  // up to 63 ms: also a stall
  const double period_s = static_cast<double>(scene.header().period_ns) * 1e-9;
  const auto& xyzw = scene.scene().device.orientation_xyzw;
  const Eigen::Quaterniond turn(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  for (std::size_t i = 0; i < renderings_.size(); ++i) {
    auto& [renderer, safety] = renderings_[i];
    const rendering::RenderedTick tick = renderer->render(scene, pose, now_ns_);
    require(tick.weights.alpha >= 0.0 && tick.weights.alpha <= 1.0,
            "a transition's progress is within [0, 1]");
    require(tick.age_s >= 0.0 && tick.snapshot_age_s >= 0.0, "an age is no less than zero");
    constexpr auto kMaxPlaneContacts = proto::kMaxPlanes * proto::kMaxToolSpheres;
    require(
        tick.force.contacts >= 0 && static_cast<std::size_t>(tick.force.contacts) <=
                                        rendering::TouchedSpheres::kCapacity + kMaxPlaneContacts,
        "a tick's contacts are bounded");
    std::uint32_t flags = 0;
    const safety::Wrench commanded =
        safety.apply({.rendered = {tick.force.force_N, tick.force.torque_N_m},
                      .stiffness_N_per_m = tick.force.stiffness_N_per_m,
                      .snapshot = {.exists = tick.snapshot_id != 0,
                                   .snapshot_age_s = tick.snapshot_age_s,
                                   .period_s = period_s,
                                   .writer_alive = writer_alive},
                      .velocity_m_s = pose.velocity_m_s,
                      .elapsed_s = elapsed_s},
                     flags);
    const double growth_N = commanded.force_N.norm() - slewed_N_.norm();
    require(commanded.torque_N_m.norm() <= kLever_m * kMaxForce_N * (1.0 + 1e-9),
            "the torque told is within what the force's limit makes at the lever");
    if (i == kSlewed && (flags & safety::kFlagStalled) == 0)
      require(growth_N <= kMaxSlew_N_per_ms * (1.0 + 1e-9),
              "the force grows no faster than the slew limit");
    if (i == kSlewed) slewed_N_ = commanded.force_N;
    const Eigen::Vector3d commanded_N = turn.conjugate() * commanded.force_N;
    require(commanded_N.allFinite(), "the force commanded to the device is finite");
    require(commanded_N.norm() <= kMaxForce_N * (1.0 + 1e-9),
            "the force commanded is within the limit");
  }
}

}  // namespace stillgrid::fuzz

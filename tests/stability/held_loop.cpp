#include "tests/stability/held_loop.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "shared/rendering/tool_force.hpp"
#include "shared/rendering/velocity_estimator.hpp"

namespace stillgrid::laboratory {
namespace {

constexpr float kContactDistance_m = 0.05F;
constexpr double kUnit = 0x1p-10;  // of a state: the spring is one within its reach only

proto::SceneHeader scene_of(double stiffness_N_per_m, double damping_N_s_per_m,
                            float tool_radius_m) {
  proto::SceneHeader scene{};
  scene.material_count = 1;
  scene.materials[0] = {static_cast<float>(stiffness_N_per_m),
                        static_cast<float>(damping_N_s_per_m), 0.0F, 1e-3F};
  scene.plane_count = 1;
  scene.planes[0] = {{0.0F, 0.0F, 1.0F}, 0.0F, 0, 0};
  scene.tool_sphere_count = 1;
  scene.tool[0] = {{0.0F, 0.0F, 0.0F}, tool_radius_m};
  return scene;
}

/// Velocity of the tool that was at before_m one tick ago with the estimate before_m_s, and is at
/// now_m.
double velocity_m_s(VelocitySource source, const std::array<double, 2>& before, double now_m,
                    double tick_s) {
  const auto [before_m, before_m_s] = before;
  if (source == VelocitySource::kBackwardDifference) return (now_m - before_m) / tick_s;
  const auto tick_ns = static_cast<std::uint64_t>(std::llround(tick_s * 1e9));
  const auto at = [](double z_m) { return Eigen::Vector3d(0.0, 0.0, z_m); };
  // What share of a step's rate one update takes over; thence the step that leads to before_m_s.
  rendering::VelocityEstimator probe;
  (void)probe.update(0, at(0.0));
  const double pull = probe.update(tick_ns, at(tick_s)).z();
  rendering::VelocityEstimator estimator;
  (void)estimator.update(0, at(before_m - before_m_s * tick_s / pull));
  (void)estimator.update(tick_ns, at(before_m));
  return estimator.update(2 * tick_ns, at(now_m)).z();
}

/// The loop's state one tick on. State: position, velocity, position and velocity estimate of the
/// tick before, forces on their way, the next one first.
Eigen::VectorXd next_tick(devices::PhantomModel device, const proto::SceneHeader& scene,
                          VelocitySource source, const Eigen::VectorXd& state) {
  const auto delay = static_cast<std::size_t>(device.settings.delay_ticks);
  device.position_m.z() = state[0];
  device.velocity_m_s.z() = state[1];
  for (std::size_t i = 0; i < delay; ++i)
    device.delayed_N[i + 1] = {0.0, 0.0, state[static_cast<Eigen::Index>(4 + i)]};

  const double now_m = devices::read_encoders(device).z();
  const double now_m_s = velocity_m_s(source, {state[2], state[3]}, now_m, device.settings.tick_s);
  devices::command_force(device, {0.0, 0.0, force_N(scene, now_m, now_m_s)});
  devices::advance_phantom(device, devices::kSubstepsPerTick);

  Eigen::VectorXd next(state.size());
  next.head<4>() << device.position_m.z(), device.velocity_m_s.z(), now_m, now_m_s;
  for (std::size_t i = 0; i < delay; ++i)
    next[static_cast<Eigen::Index>(4 + i)] = device.delayed_N[(i + 2) % (delay + 1)].z();
  return next;
}

}  // namespace

devices::PhantomModel make_device(const HeldLoop& loop) {
  devices::PhantomSettings settings;
  settings.device.mass_kg = loop.mass_kg;
  settings.device.damping_N_s_per_m = loop.damping_N_s_per_m;
  settings.device.friction_N = loop.friction_N;
  settings.device.resolution_m = loop.resolution_m;
  settings.path.kind = devices::PathKind::kStill;
  settings.tick_s = loop.tick_s;
  settings.delay_ticks = loop.delay_ticks;
  return devices::make_phantom(settings);
}

devices::PhantomModel make_pushed_device(const HeldLoop& loop, double push_N) {
  devices::PhantomModel device = make_device(loop);
  device.settings.push_N = {0.0, 0.0, -push_N};
  device.velocity_m_s = {0.0, 0.0, -0.05};
  return device;
}

proto::SceneHeader wall(double stiffness_N_per_m) {
  return scene_of(stiffness_N_per_m, 0.0, 0.0F);
}

proto::SceneHeader spring(double stiffness_N_per_m, double damping_N_s_per_m) {
  proto::SceneHeader scene =
      scene_of(0.5 * stiffness_N_per_m, damping_N_s_per_m, kContactDistance_m);
  scene.plane_count = 2;
  scene.planes[1] = {{0.0F, 0.0F, -1.0F}, 0.0F, 0, 0};
  return scene;
}

double force_N(const proto::SceneHeader& scene, double z_m, double velocity_m_s) {
  static const rendering::TouchedSpheres kNoSpheres{};
  const rendering::PlacedToolSphere tool{.position_m = {0.0, 0.0, z_m},
                                         .radius_m = static_cast<double>(scene.tool[0].radius_m)};
  const rendering::ToolPose pose{.position_m = {0.0, 0.0, z_m},
                                 .velocity_m_s = {0.0, 0.0, velocity_m_s}};
  return rendering::tool_force(scene, kNoSpheres, {&tool, 1}, pose).force_N.z();
}

double tick_growth(const HeldLoop& loop, double stiffness_N_per_m, double damping_N_s_per_m,
                   VelocitySource source) {
  const devices::PhantomModel device = make_device(loop);
  const proto::SceneHeader scene = spring(stiffness_N_per_m, damping_N_s_per_m);
  const Eigen::Index size = 4 + loop.delay_ticks;
  Eigen::MatrixXd matrix(size, size);
  for (Eigen::Index i = 0; i < size; ++i)
    matrix.col(i) =
        next_tick(device, scene, source, kUnit * Eigen::VectorXd::Unit(size, i)) / kUnit;
  return matrix.eigenvalues().cwiseAbs().maxCoeff();
}

double first_loss_N_per_m(const std::function<double(double)>& growth, double lowest_N_per_m) {
  constexpr double kRounding = 1e-11;
  const auto is_stable = [&](double stiffness_N_per_m) {
    return growth(stiffness_N_per_m) <= 1.0 + kRounding;
  };
  double stable = lowest_N_per_m, unstable = 1.1 * lowest_N_per_m;
  while (is_stable(unstable)) stable = std::exchange(unstable, 1.1 * unstable);
  while (unstable - stable > 1e-9 * stable) {
    const double middle = 0.5 * (stable + unstable);
    (is_stable(middle) ? stable : unstable) = middle;
  }
  return stable;
}

double peak_to_peak(std::vector<double>::const_iterator first,
                    std::vector<double>::const_iterator last) {
  const auto [low, high] = std::minmax_element(first, last);
  return *high - *low;
}

}  // namespace stillgrid::laboratory

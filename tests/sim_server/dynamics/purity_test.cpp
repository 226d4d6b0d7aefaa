// Who looks on changes nothing: accounts, snapshots.

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "sim_server/dynamics/step/simulation.hpp"
#include "sim_server/published_scene.hpp"
#include "sim_server/scene/scene_file.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::dynamics::purity_test {
namespace {

/// Every number of the world that moves.
std::vector<double> state_of(const bodies::World& world) {
  std::vector<double> state{world.time_s};
  const auto add = [&](const auto& vector) {
    state.insert(state.end(), vector.data(), vector.data() + vector.size());
  };
  for (const bodies::Node& node : world.nodes) {
    add(node.position_m);
    add(node.velocity_m_s);
  }
  for (const bodies::RigidBody& body : world.rigid_bodies) {
    add(body.position_m);
    add(body.velocity_m_s);
    add(body.orientation.coeffs());
    add(body.angular_velocity_rad_s);
  }
  for (const bodies::BodyRange& body : world.bodies) state.push_back(body.is_sleeping ? 1.0 : 0.0);
  return state;
}

struct Looks {
  bool accounts = true, publishes = true;
};

/// What looking on leaves of two runs of a scene side by side.
struct Seen {
  int first_change = -1;  // step after which the worlds were not the same to the byte; -1: none
  int most_contacts = 0;
};

/// A tool that dips into the middle of a scene and stirs it, which comes after a few steps.
std::optional<ToolSample> stirring_tool(const scene::SceneDescription& scene, int step) {
  if (step < 4) return std::nullopt;
  const double time_s = step * scene.period_s;
  ToolSample sample;
  sample.time_ns = 1 + static_cast<std::uint64_t>(1e9 * time_s);
  sample.position_m = scene.device.position_m +
                      Eigen::Vector3d(0.02 * std::sin(9.0 * time_s), 0.015 * std::cos(7.0 * time_s),
                                      -0.04 * (1.0 - std::cos(5.0 * time_s)));
  return sample;
}

Seen look_on(const scene::SceneDescription& scene, int steps, Looks looks = {}) {
  Simulation watched(scene), alone(scene);
  std::optional<publication::SceneWriter> writer;
  if (looks.publishes)
    writer.emplace("purity-" + std::to_string(::getpid()), sim_server::static_scene(scene, watched),
                   watched.world().spheres.size(), 10'000'000, proto::Clock::kVirtual, 0);
  if (looks.accounts) watched.account_energy();
  Seen seen;
  for (int i = 0; i < steps; ++i) {
    const auto tool = [&] { return stirring_tool(scene, i); };
    const StepReport report = watched.step(scene.period_s, tool);
    const StepReport other = alone.step(scene.period_s, tool);
    CHECK(report.tools[0].work_J == other.tools[0].work_J);
    seen.most_contacts = std::max(seen.most_contacts, report.contacts);
    if (looks.accounts && i % 5 == 0) (void)watched.energy_account();
    const std::uint64_t now_ns = 1000 * static_cast<std::uint64_t>(i + 1);
    if (writer)
      writer->publish(watched.snapshot(), {.state_ns = now_ns, .publish_ns = now_ns},
                      watched.field_records());
    if (state_of(watched.world()) == state_of(alone.world())) continue;
    seen.first_change = i;
    break;
  }
  return seen;
}

/// Balls that fall on each other and on a floor, some at sleep soon, a thread over them, a paddle
/// through them: dozens of pairs, so that their order tells.
scene::SceneDescription heap(unsigned seed, const scene::IntegratorKind& integrator) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> aside(-0.002, 0.002), size(0.8, 1.3), speed(-0.4, 0.4);
  std::vector<bodies::BodyDescription> bodies{sim_server::floor_at(0.0)};
  for (int i = 0; i < 48; ++i)
    bodies.push_back(sim_server::moving(
        sim_server::sphere({0.017 * (i % 4) + aside(random), 0.017 * (i / 4 % 4) + aside(random),
                            0.0119 + 0.0205 * (i / 16)},
                           0.009 * size(random), 0.02),
        {speed(random), speed(random), speed(random)}));
  bodies.push_back(sim_server::thread(9, {-0.03, 0.02, 0.08}, {0.08, 0.025, 0.085}, 0.002, 40.0));
  bodies.push_back(sim_server::box({-0.09, 0.02, 0.02}, {0.02, 0.04, 0.02}, 0.0, {0.01, 0.006}));
  bodies.back().motion = bodies::Motion::kPrescribed;
  bodies.back().prescribed = {
      .direction = Eigen::Vector3d::UnitX(), .amplitude_m = 0.04, .frequency_hz = 3.1};
  scene::SceneDescription scene = sim_server::scene_of(
      std::move(bodies), sim_server::material_of(2000.0, 1.0, 0.3), {0, 0, -9.81});
  scene.tool = {{Eigen::Vector3d::Zero(), 0.01}, {{0.013, 0, 0}, 0.008}};
  scene.device.position_m = {0.03, 0.03, 0.075};
  scene.period_s = 0.0103;
  scene.sleeping = true;
  scene.method.integrator = integrator;
  return scene;
}

TEST_CASE("Accounting and publishing change no byte of how a heap moves", "[purity]") {
  const auto integrator =
      GENERATE(scene::IntegratorKind::kVelocityVerlet, scene::IntegratorKind::kImplicitEuler);
  const bool is_explicit = scene::is_explicit(integrator);
  for (unsigned seed = 1; seed <= (tests::kIsSanitized ? 2 : 8); ++seed) {
    INFO(scene::name_of(integrator) << ", seed " << seed);
    const Seen seen = look_on(heap(seed, integrator), is_explicit ? 60 : 24);
    CHECK(seen.first_change == -1);
    CHECK(seen.most_contacts >= 12);
  }
}

TEST_CASE("Accounting and publishing change no byte of the scenes that ship", "[purity]") {
  const std::string name = GENERATE("tissue_and_blocks", "threads", "organ", "laparoscopy");
  const auto integrator =
      GENERATE(scene::IntegratorKind::kVelocityVerlet, scene::IntegratorKind::kImplicitEuler);
  scene::SceneDescription scene = scene::load_scene(std::filesystem::path(STILLGRID_SOURCE_DIR) /
                                                    "sim_server/scene/scenes" / (name + ".toml"));
  scene.method = {.integrator = integrator};
  scene.period_s = std::max(scene.period_s, 0.01);  // long enough to come to contacts
  INFO(name << ", " << scene::name_of(integrator));
  const Seen seen = look_on(scene, scene::is_explicit(integrator) ? 30 : 24);
  CHECK(seen.first_change == -1);
  CHECK(seen.most_contacts > 0);
}

}  // namespace
}  // namespace stillgrid::dynamics::purity_test

/// Finding all pairs of N moving spheres that overlap: ours, the paper's grid, Bullet and FCL, side
/// by side on the same paths. Prints CSV; scripts/gallery/measure_detection.py runs it.
/// detection_benchmark [ROUNDS [MOST [LEAST]]]: spheres from LEAST to MOST in steps of ten.
#include <hwy/targets.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim_server/contact/detection.hpp"
#include "sim_server/contact/moving_spheres.hpp"
#include "sim_server/snapshot/moving_snapshot.hpp"
#include "tests/performance/detection_peers.hpp"
#include "tests/performance/paper_grid.hpp"
#include "tests/performance/sphere_cloud.hpp"
#include "tests/sim_server/scene_builders.hpp"

namespace stillgrid::performance {
namespace {

using Frame = std::vector<collision::SweptBound>;

struct Method {
  std::string name;
  std::function<std::size_t(const Frame&)> find;
  int most_rounds;             // slow ones run fewer
  std::int64_t target = 0;     // instruction set, 0: the best
  bool finds_overlaps = true;  // all of them and no more
};

/// Processor time of this thread: what others do on a shared machine is left out, but for caches.
double thread_ns() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

/// Makes ours use an instruction set, and looks it up now rather than while time is taken.
void choose(std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// Ours, with the instruction set `target`, or the best.
Method ours(const std::string& name, const SphereCloud& cloud, std::int64_t target, bool shows) {
  const std::size_t count = cloud.count();
  struct State {
    contact::MovingSpheres spheres;
    snapshot::MovingSnapshot snapshot;
    std::vector<proto::SphereState> snapshots;
  };
  auto state = std::make_shared<State>(
      State{contact::MovingSpheres(count, 0.0F), {}, std::vector<proto::SphereState>(count)});
  for (std::size_t i = 0; i < count; ++i)
    state->spheres.grid().records()[i].radius_m = cloud.radius_m(i);
  return {name,
          [=](const Frame& balls) {
            const std::size_t found = state->spheres.find(balls).size();
            if (shows) {
              for (std::size_t i = 0; i < balls.size(); ++i)
                state->snapshots[i].position_m = balls[i].centre_m;
              state->snapshot.show(state->snapshots, state->spheres);
            }
            return found;
          },
          1000, target};
}

/// What a step of the simulation does to find its contacts, of as many free balls: places and
/// velocities taken from the world, paths covered, pairs searched, contacts made. It lists what may
/// touch within the step, which is more than overlaps.
Method in_a_step(const SphereCloud& cloud) {
  constexpr double kStep_s = 0.01;
  std::vector<bodies::BodyDescription> bodies;
  for (std::size_t i = 0; i < cloud.count(); ++i)
    bodies.push_back(sim_server::sphere(cloud.position_m(i), double{cloud.radius_m(i)}, 0.1));
  struct State {
    bodies::World world;
    contact::Detection detection;
  };
  const bodies::World world = scene::build_world(sim_server::scene_of(std::move(bodies)));
  auto state = std::make_shared<State>(State{world, contact::Detection(world, 0.0)});
  return {.name = "ours, in a step",
          .find =
              [=](const Frame& balls) {
                for (std::size_t i = 0; i < balls.size(); ++i) {
                  bodies::RigidBody& body = state->world.rigid_bodies[i];
                  const auto& p = balls[i].centre_m;
                  const Eigen::Vector3d place_m(p[0], p[1], p[2]);
                  body.velocity_m_s = (place_m - body.position_m) / kStep_s;
                  body.position_m = place_m;
                }
                state->detection.find_contacts(state->world, kStep_s);
                return state->detection.contacts().size();
              },
          .most_rounds = 1000,
          .finds_overlaps = false};
}

Method paper(const SphereCloud& cloud, int most_rounds) {
  const auto cells = static_cast<std::uint32_t>(cloud.edge_m() / SphereCloud::voxel_m()) + 3;
  auto grid = std::make_shared<PaperGrid<std::uint32_t>>(
      SphereCloud::voxel_m(), std::array<std::uint32_t, 3>{cells, cells, cells});
  auto pairs = std::make_shared<std::vector<contact::SpherePair>>();
  return {"paper's grid",
          [=](const Frame& balls) {
            grid->find(balls, *pairs);
            return pairs->size();
          },
          most_rounds};
}

Method peer(const std::string& name, std::shared_ptr<DetectionPeer> other, int most_rounds) {
  return {name, [=](const Frame& balls) { return other->find(balls); }, most_rounds};
}

/// The axis sweep takes minutes to begin with 40,000; far: others update too slowly to be waited
/// for with many.
std::vector<Method> methods_for(const SphereCloud& cloud, const Frame& first, bool far) {
  const std::size_t n = cloud.count();
  choose(0);
  const int others = n <= 40000 ? 3 : 1;
  constexpr auto kRadius_m = static_cast<float>(SphereCloud::kRadius_m);
  std::vector<Method> methods{ours("ours", cloud, 0, false),
                              ours("ours, and shown", cloud, 0, true)};
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    methods.push_back(ours(std::string("ours, ") + hwy::TargetName(target), cloud, target, false));
  if (n <= 40000) methods.push_back(in_a_step(cloud));
  methods.push_back(paper(cloud, others));
  if (n <= (far ? 400U : 4000U))
    methods.push_back(peer("Bullet axis sweep",
                           bullet_axis_sweep(first, static_cast<float>(cloud.edge_m())), others));
  methods.push_back(peer("Bullet tree", bullet_tree(first, 0.0F), others));
  methods.push_back(peer("Bullet tree, margin R/4", bullet_tree(first, 0.25F * kRadius_m), others));
  if (!far || n <= 4000) methods.push_back(peer("FCL tree", fcl_tree(first), far ? 1 : others));
  return methods;
}

void measure(const std::string& motion, double move_m, std::size_t count, int rounds) {
  SphereCloud cloud(count, 1, move_m);
  Frame balls(count);
  cloud.write_to(balls);
  const std::vector<Method> methods = methods_for(cloud, balls, move_m > SphereCloud::kRadius_m);
  // About so many steps that ours makes its lists anew a few times.
  const std::size_t steps = count <= 400 ? 200 : count <= 4000 ? 80 : count <= 40000 ? 40 : 20;
  std::vector<Frame> frames(steps, balls);
  for (int round = -1; round < rounds; ++round) {  // the first warms up
    for (Frame& frame : frames) {
      cloud.move();
      cloud.write_to(frame);
    }
    std::size_t expected = 0;
    for (const Method& method : methods) {
      const bool warms_up = round < 0 && method.most_rounds > 1;
      if (!warms_up && (round < 0 || round >= method.most_rounds)) continue;
      choose(method.target);
      std::size_t found = 0;
      const double start_ns = thread_ns();
      for (const Frame& frame : frames) found += method.find(frame);
      const double step_ns = (thread_ns() - start_ns) / static_cast<double>(steps);
      if (&method == &methods.front()) expected = found;
      if (method.finds_overlaps && found != expected) {
        std::fprintf(stderr, "%s finds %zu pairs, ours %zu\n", method.name.c_str(), found,
                     expected);
        std::exit(1);
      }
      if (round >= 0)
        std::printf("%s,\"%s\",%zu,%d,%.3f,%.3f\n", motion.c_str(), method.name.c_str(), count,
                    round, step_ns / static_cast<double>(count),
                    static_cast<double>(found) / static_cast<double>(steps * count));
      std::fflush(stdout);
    }
  }
}

int program_main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 15;
  const std::size_t most = argc > 2 ? static_cast<std::size_t>(std::atoll(argv[2])) : 400000;
  const std::size_t least = argc > 3 ? static_cast<std::size_t>(std::atoll(argv[3])) : 400;
  std::printf("motion,method,spheres,round,ns,pairs_each\n");
  for (std::size_t n = least; n <= most; n *= 10) {
    measure("slow", 0.05 * SphereCloud::kRadius_m, n, rounds);
    measure("far", 3.0 * SphereCloud::kRadius_m, n, rounds);
  }
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main(int argc, char** argv) {
  return stillgrid::performance::program_main(argc, argv);
}

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "proto/stillgrid.h"

/// An engine of one ball on a floor, in virtual time: ball_engine SESSION PERIOD_S MASS_KG WITH,
/// WITH being nothing or response. Its own steps are a hundredth of a period.
namespace {

constexpr double kRadius_m = 0.02, kFloor_m = -0.05, kGravity_m_s2 = 9.81;
constexpr int kSubsteps = 100;

void require(int code) {
  if (code >= 0) return;
  std::fprintf(stderr, "ball_engine: %s\n", stillgrid_last_error());
  std::exit(1);
}

struct Ball {
  double position_m[3] = {0.0, 0.0, -0.032}, velocity_m_s[3] = {};
  double mass_kg;

  /// The floor is a spring and a damper; a weak spring keeps the ball from rolling away.
  void step(double period_s, const double* pushed_N) {
    const double step_s = period_s / kSubsteps;
    for (int i = 0; i < kSubsteps; ++i) {
      const double depth_m = kRadius_m - (position_m[2] - kFloor_m);
      const double damped_N = velocity_m_s[2] < 0.0 ? -0.5 * velocity_m_s[2] : 0.0;
      const double floor_N = depth_m > 0.0 ? 250.0 * depth_m + damped_N : 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double other_N = axis == 2 ? floor_N - mass_kg * kGravity_m_s2
                                         : -20.0 * position_m[axis] - 0.5 * velocity_m_s[axis];
        velocity_m_s[axis] += step_s * (pushed_N[axis] + other_N) / mass_kg;
        position_m[axis] += step_s * velocity_m_s[axis];
      }
    }
  }
};

void show(stillgrid_publisher* publisher, const Ball& ball, bool responds) {
  require(stillgrid_publisher_set_spheres(publisher, 1, ball.position_m, ball.velocity_m_s));
  if (!responds) return;
  stillgrid_response response{};
  std::memcpy(response.centre_m, ball.position_m, sizeof response.centre_m);
  std::memcpy(response.velocity, ball.velocity_m_s, sizeof ball.velocity_m_s);
  for (int i = 0; i < 6; ++i)
    response.inverse_inertia[7 * i] =
        i < 3 ? 1.0 / ball.mass_kg : 2.5 / (ball.mass_kg * kRadius_m * kRadius_m);
  require(stillgrid_publisher_set_responses(publisher, 1, &response));
}

void one_step(stillgrid_publisher* publisher, Ball& ball, double period_s, bool responds) {
  stillgrid_push push{};
  std::uint32_t count = 1;
  require(stillgrid_publisher_pushes(publisher, period_s, &push, &count));
  ball.step(period_s, push.force_N);
  show(publisher, ball, responds);
  require(stillgrid_publisher_publish(publisher, 0));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  const double period_s = std::atof(argv[2]);
  const bool responds = std::strcmp(argv[4], "response") == 0;
  const stillgrid_material material{500.0, 1.0, 0.3};
  const stillgrid_plane floor{{0.0, 0.0, 1.0}, kFloor_m, 0, 1};
  stillgrid_scene scene{};
  scene.struct_size = sizeof scene;
  scene.clock = STILLGRID_VIRTUAL_TIME;
  scene.session = argv[1];
  scene.period_s = period_s;
  scene.sphere_capacity = 1;
  scene.gives_inertia = responds ? 1 : 0;
  scene.material_count = scene.plane_count = 1;
  scene.materials = &material;
  scene.planes = &floor;
  stillgrid_publisher* publisher = nullptr;
  require(stillgrid_publisher_open(&scene, &publisher));
  stillgrid_shapes shapes{};
  shapes.struct_size = sizeof shapes;
  shapes.count = 1;
  shapes.radii_m = &kRadius_m;
  require(stillgrid_publisher_set_shapes(publisher, &shapes));
  Ball ball;
  ball.mass_kg = std::atof(argv[3]);
  show(publisher, ball, responds);
  std::uint64_t time_ns = 0;
  int code;
  while ((code = stillgrid_publisher_wait(publisher, &time_ns)) != STILLGRID_NOTHING) {
    require(code);
    if (code == STILLGRID_OK) one_step(publisher, ball, period_s, responds);
  }
  stillgrid_publisher_close(publisher);
  return 0;
}

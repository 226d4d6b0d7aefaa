#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/library/published_ball.hpp"

namespace stillgrid::library::publisher_test {
namespace {

using Catch::Contains;
using Eigen::Vector3d;

TEST_CASE("A sphere that comes is in no older snapshot, and one that goes in no newer",
          "[publisher]") {
  Published scene("coming", {});
  scene.declare({0.01, 0.02}, {0, 1});
  scene.place({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {Vector3d::Zero(), Vector3d::Zero()});
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  scene.declare({0.01, 0.02, 0.03}, {0, 1, 2});
  scene.place({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}},
              std::vector<Vector3d>(3, Vector3d::Zero()));
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  auto snapshot = scene.snapshot();
  REQUIRE(snapshot.spheres.size() == 3);
  CHECK(snapshot.spheres[1].before.position_m[0] == 1.0F);
  CHECK(std::isnan(snapshot.spheres[2].before.position_m[0]));
  // Another body under the same number has no past either.
  scene.declare({0.01, 0.02}, {0, 5});
  scene.place({{0.0, 0.0, 0.0}, {1.5, 0.0, 0.0}}, std::vector<Vector3d>(2, Vector3d::Zero()));
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  snapshot = scene.snapshot();
  REQUIRE(snapshot.spheres.size() == 2);
  CHECK(snapshot.spheres[0].before.position_m[0] == 0.0F);
  CHECK(std::isnan(snapshot.spheres[1].before.position_m[0]));
}

TEST_CASE("Without velocities spheres move on as they did", "[publisher]") {
  Published scene("moving", {.period_s = 0.02});
  scene.declare({0.01}, {0});
  for (const double x_m : {0.0, 0.01, 0.03}) {
    const double position_m[] = {x_m, 0.0, 0.0};
    REQUIRE(stillgrid_publisher_set_spheres(scene, 1, position_m, nullptr) == STILLGRID_OK);
    REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  }
  CHECK(scene.snapshot().spheres[0].newest.velocity_m_s[0] == Approx(1.0F));
}

TEST_CASE("What a call refuses changes nothing, and is told in one line", "[publisher]") {
  Published scene("refused", {.capacity = 2, .gives_inertia = 0});
  const double nothing[] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  const auto line = [] { return std::string(stillgrid_last_error()); };

  CHECK(stillgrid_publisher_publish(scene, 0) == STILLGRID_E_ORDER);
  CHECK_THAT(line(), Contains("set_spheres() first"));
  CHECK(stillgrid_publisher_set_spheres(scene, 1, nothing, nothing) == STILLGRID_E_ORDER);
  CHECK_THAT(line(), Contains("set_shapes() first"));
  scene.declare({0.01, 0.01}, {0, 1});
  scene.place({{0.1, 0.0, 0.0}, {0.2, 0.0, 0.0}}, {Vector3d::Zero(), Vector3d::Zero()});
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);

  const double bad[] = {0.0, 0.0, 0.0, 0.0, std::numeric_limits<double>::quiet_NaN(), 0.0};
  CHECK(stillgrid_publisher_set_spheres(scene, 2, bad, nothing) == STILLGRID_E_ARGUMENT);
  CHECK_THAT(line(), Contains("positions_m[4]: nan"));
  CHECK(stillgrid_publisher_set_spheres(scene, 2, nothing, bad) == STILLGRID_E_ARGUMENT);
  CHECK_THAT(line(), Contains("velocities_m_s[4]"));
  const double far[] = {0.0, 1e300, 0.0, 0.0, 0.0, 0.0};
  CHECK(stillgrid_publisher_set_spheres(scene, 2, far, nothing) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_publisher_set_spheres(scene, 1, nothing, nothing) == STILLGRID_E_ARGUMENT);
  CHECK_THAT(line(), Contains("1 spheres: expected the 2"));
  CHECK(stillgrid_publisher_set_spheres(scene, 2, nullptr, nothing) == STILLGRID_E_ARGUMENT);
  const double radii_m[] = {0.01, 0.0, 0.01};
  stillgrid_shapes shapes{};
  shapes.struct_size = sizeof shapes;
  shapes.radii_m = radii_m;
  shapes.count = 3;
  CHECK(stillgrid_publisher_set_shapes(scene, &shapes) == STILLGRID_E_CAPACITY);
  CHECK_THAT(line(), Contains("shapes.count: 3: expected the 2"));
  shapes.count = 2;
  CHECK(stillgrid_publisher_set_shapes(scene, &shapes) == STILLGRID_E_ARGUMENT);
  CHECK_THAT(line(), Contains("shapes.radii_m[1]: 0"));
  const std::uint32_t materials[] = {0, 1};
  const double sound_m[] = {0.01, 0.01};
  shapes.radii_m = sound_m;
  shapes.materials = materials;
  CHECK(stillgrid_publisher_set_shapes(scene, &shapes) == STILLGRID_E_ARGUMENT);
  CHECK_THAT(line(), Contains("shapes.materials[1]: 1: expected 0 to 0"));
  shapes.struct_size = 4;
  CHECK(stillgrid_publisher_set_shapes(scene, &shapes) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_publisher_set_shapes(scene, nullptr) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_publisher_set_shapes(nullptr, &shapes) == STILLGRID_E_ARGUMENT);
  const stillgrid_response response = ball_response(0, Vector3d::Zero(), 1.0, 0.01);
  CHECK(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_E_ORDER);
  CHECK_THAT(line(), Contains("scene.gives_inertia of 1"));
  std::uint32_t count = 0;
  CHECK(stillgrid_publisher_pushes(scene, 0.0, nullptr, &count) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_publisher_pushes(scene, 0.01, nullptr, nullptr) == STILLGRID_E_ARGUMENT);
  stillgrid_tool tool{};
  tool.struct_size = sizeof tool;
  CHECK(stillgrid_publisher_tool(scene, 1, &tool) == STILLGRID_E_ARGUMENT);
  CHECK(stillgrid_publisher_tool(scene, 0, &tool) == STILLGRID_NOTHING);
  CHECK(line().find('\n') == std::string::npos);

  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  const auto snapshot = scene.snapshot();
  REQUIRE(snapshot.spheres.size() == 2);
  CHECK(snapshot.spheres[0].newest.position_m[0] == 0.1F);
  CHECK(snapshot.spheres[1].newest.position_m[0] == 0.2F);
}

TEST_CASE("An inverse inertia that no body has is refused", "[publisher]") {
  Published scene("inertia", {});
  scene.declare({0.01}, {0});
  scene.place({Vector3d::Zero()}, {Vector3d::Zero()});
  stillgrid_response response = ball_response(0, Vector3d::Zero(), 1.0, 0.01);
  const auto refused = [&] {
    return stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_E_ARGUMENT;
  };
  response.inverse_inertia[1] = 0.5;
  CHECK(refused());  // not symmetric
  response.inverse_inertia[6] = 0.5;
  CHECK(!refused());
  response.inverse_inertia[1] = response.inverse_inertia[6] = 2.0;
  CHECK(refused());  // an eigenvalue of -1
  response = ball_response(0, Vector3d::Zero(), 1.0, 0.01);
  response.inverse_inertia[14] = std::numeric_limits<double>::infinity();
  CHECK(refused());
  const stillgrid_response twice[] = {ball_response(0, Vector3d::Zero(), 1.0, 0.01),
                                      ball_response(0, Vector3d::Zero(), 1.0, 0.01)};
  CHECK(stillgrid_publisher_set_responses(scene, 2, twice) == STILLGRID_E_ARGUMENT);
  response = {};  // it does not give way at all
  CHECK(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK);
}

TEST_CASE("A scene that no reader would take is refused before the session is taken",
          "[publisher]") {
  const std::string session = own_session("scene");
  stillgrid_material material{500.0, 1.0, 0.3};
  stillgrid_plane plane{{0.0, 0.0, 1.0}, 0.0, 0, 0};
  stillgrid_scene scene{};
  scene.struct_size = sizeof scene;
  scene.session = session.c_str();
  scene.period_s = 0.01;
  scene.sphere_capacity = 4;
  scene.material_count = 1;
  scene.materials = &material;
  scene.plane_count = 1;
  scene.planes = &plane;
  stillgrid_publisher* publisher = nullptr;
  const auto is_refused = [&](const char* text, int code = STILLGRID_E_ARGUMENT) {
    INFO(text);
    const int got = stillgrid_publisher_open(&scene, &publisher);
    CHECK(got == code);
    CHECK(publisher == nullptr);
    CHECK_THAT(stillgrid_last_error(), Contains(text));
    stillgrid_publisher_close(publisher);
  };
  scene.period_s = 0.0;
  is_refused("scene.period_s: 0");
  scene.period_s = std::numeric_limits<double>::quiet_NaN();
  is_refused("scene.period_s: nan");
  scene.period_s = 0.01;
  plane.normal[0] = 0.3;
  is_refused("scene.planes[0]: normal");
  plane.normal[0] = 0.0;
  plane.material = 1;
  is_refused("scene.planes[0].material: 1");
  plane.material = 0;
  material.friction = -0.1;
  is_refused("scene.materials[0]");
  material.friction = 0.3;
  material.stiffness_N_per_m = -1.0;
  is_refused("scene.materials[0]");
  material.stiffness_N_per_m = 500.0;
  scene.material_count = 65;
  is_refused("scene.material_count: 65", STILLGRID_E_CAPACITY);
  scene.material_count = 1;
  scene.sphere_capacity = 1U << 31U;
  is_refused("scene.sphere_capacity", STILLGRID_E_CAPACITY);
  scene.sphere_capacity = 4;
  scene.session = "no/slash";
  is_refused("scene.session");
  scene.session = "";
  is_refused("expected 1 to 64 letters", STILLGRID_E_SESSION);
  scene.session = session.c_str();
  const std::string long_name(64, 'x');
  scene.name = long_name.c_str();
  is_refused("scene.name: 64 bytes");
  scene.name = nullptr;
  scene.struct_size = 8;
  is_refused("scene.struct_size: 8");
  scene.struct_size = sizeof scene;
  REQUIRE(stillgrid_publisher_open(&scene, &publisher) == STILLGRID_OK);
  stillgrid_publisher* second = nullptr;
  CHECK(stillgrid_publisher_open(&scene, &second) == STILLGRID_E_SESSION);
  CHECK(second == nullptr);
  stillgrid_publisher_close(publisher);
}

TEST_CASE("A second thread in a call is told so, and does nothing", "[publisher]") {
  Published scene("threads", {.capacity = 1});
  scene.declare({0.01}, {0});
  const double at_m[] = {0.0, 0.0, 0.0};
  std::atomic<int> refused = 0, other = 0, done = 0;
  const auto work = [&] {
    for (int i = 0; i < 20'000; ++i) {
      const int code = stillgrid_publisher_set_spheres(scene, 1, at_m, at_m);
      ++(code == STILLGRID_OK ? done : code == STILLGRID_E_THREAD ? refused : other);
    }
  };
  std::thread one(work), two(work);
  one.join();
  two.join();
  CHECK(other == 0);
  CHECK(done + refused == 40'000);
  CHECK(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
}

TEST_CASE("A step of a publisher allocates nothing", "[publisher]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  Published scene("allocations", {.clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({0.02, 0.02}, {0, 1});
  scene.hold({0.0, 0.0, 0.0245});
  const stillgrid_response response = ball_response(0, Vector3d::Zero(), 0.1, 0.02);
  std::uint64_t allocated = 0;
  const auto step = [&](double x_m) {
    const double at_m[] = {0.0, 0.0, 0.0, x_m, 0.3, 0.0}, still[6] = {};
    stillgrid_push pushes[4];
    std::uint32_t count = 4;
    scene.wait();
    const std::uint64_t before = *devices::allocation_count();
    const bool is_done =
        (x_m == 0.0 || stillgrid_publisher_pushes(scene, 0.01, pushes, &count) == STILLGRID_OK) &&
        stillgrid_publisher_set_spheres(scene, 2, at_m, still) == STILLGRID_OK &&
        stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_OK &&
        stillgrid_publisher_publish(scene, 0) == STILLGRID_OK;
    allocated = *devices::allocation_count() - before;
    return is_done && (x_m == 0.0 || count == 1);
  };
  REQUIRE(step(0.0));
  std::uint64_t least = ~0ULL;
  for (int tries = 1; tries < 50 && least > 0; ++tries) {
    REQUIRE(step(0.001 * tries));
    least = std::min(least, allocated);
  }
  CHECK(least == 0);
}

TEST_CASE("A child of a fork has no part in its parent's session", "[publisher]") {
  Published scene("fork", {.capacity = 1});
  scene.declare({0.01}, {0});
  scene.place({Vector3d::Zero()}, {Vector3d::Zero()});
  const pid_t child = ::fork();
  if (child == 0) {
    const int code = stillgrid_publisher_publish(scene, 0);
    stillgrid_publisher_close(scene);
    ::_exit(code == STILLGRID_E_ORDER ? 0 : 1);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  REQUIRE(stillgrid_publisher_publish(scene, 0) == STILLGRID_OK);
  CHECK(scene.snapshot().spheres.size() == 1);
}

TEST_CASE("What was refused does not undo what was given", "[publisher]") {
  Published scene("undone", {.clock = STILLGRID_VIRTUAL_TIME});
  scene.declare({0.02}, {0});
  scene.hold({0.0, 0.0, 0.0245});
  scene.place({Vector3d::Zero()}, {Vector3d::Zero()});
  stillgrid_response response = ball_response(0, Vector3d::Zero(), 0.01, 0.02);
  scene.respond(response);
  response.centre_m[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK(stillgrid_publisher_set_responses(scene, 1, &response) == STILLGRID_E_ARGUMENT);
  scene.wait();
  scene.publish();
  scene.wait();
  std::uint32_t count = 0;
  CHECK(stillgrid_publisher_pushes(scene, 0.01, nullptr, &count) == STILLGRID_E_CAPACITY);
  CHECK(count == 1);
  const double pushed_N = scene.pushes(0.01)[0].force_N[2];
  CHECK(std::abs(pushed_N) < 0.8 * 500.0 * 0.5e-3);  // it gives way
  CHECK(stillgrid_publisher_publish(scene, 1) == STILLGRID_E_ARGUMENT);
  scene.publish();
}

TEST_CASE("In virtual time a state is asked for, then published, in turn", "[publisher]") {
  const std::string session = own_session("virtual");
  const stillgrid_material material{500.0, 1.0, 0.3};
  stillgrid_scene scene{};
  scene.struct_size = sizeof scene;
  scene.clock = STILLGRID_VIRTUAL_TIME;
  scene.session = session.c_str();
  scene.period_s = 0.01;
  scene.material_count = 1;
  scene.materials = &material;
  stillgrid_publisher* publisher = nullptr;
  REQUIRE(stillgrid_publisher_open(&scene, &publisher) == STILLGRID_OK);
  std::uint64_t time_ns = 1;
  CHECK(stillgrid_publisher_publish(publisher, 0) == STILLGRID_E_ORDER);
  REQUIRE(stillgrid_publisher_wait(publisher, &time_ns) == STILLGRID_OK);
  CHECK(time_ns == 0);
  CHECK(stillgrid_publisher_wait(publisher, &time_ns) == STILLGRID_E_ORDER);
  REQUIRE(stillgrid_publisher_publish(publisher, 0) == STILLGRID_OK);
  CHECK(stillgrid_publisher_wait(publisher, &time_ns) == STILLGRID_AGAIN);  // nobody is there
  stillgrid_publisher_close(publisher);
}

}  // namespace
}  // namespace stillgrid::library::publisher_test

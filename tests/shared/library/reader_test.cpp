#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

#include "shared/publication/tool_segment.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/shared/library/published_session.hpp"

namespace stillgrid::library::reader_test {
namespace {

/// A tick that displays snapshot `shown` of the scene of that epoch so far on the way from the one
/// before it.
proto::ToolState tick(std::uint64_t number, std::uint64_t epoch, std::uint64_t shown,
                      double progress) {
  proto::ToolState state{};
  state.time_ns = 1'000'000 * number;
  state.tick = number;
  state.position_m = {0.25, -0.5, 0.75};
  state.orientation_xyzw = {0.0, 0.6, 0.0, 0.8};
  state.force_N = {0.0, 1.5, 0.0};
  state.before.contacts = 3;
  state.before.displayed.scene_epoch = epoch;
  state.before.displayed.snapshot_id = shown;
  state.before.displayed.alpha = progress;
  state.before.displayed.age_s = 0.02;
  return state;
}

bool are_alike(const std::vector<float>& told, const std::vector<double>& given) {
  return std::equal(told.begin(), told.end(), given.begin(), given.end(),
                    [](float a, double b) { return double{a} == b; });
}

TEST_CASE("A reader sees what a publisher publishes", "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  publish(publisher, 2);
  Reader reader(fixture.session.name().c_str());

  const SessionState state = reader.poll();
  CHECK(state.is_published == 1);
  CHECK(state.is_felt == 0);
  CHECK(state.clock == STILLGRID_REAL_TIME);
  CHECK(state.scene_epoch != 0);
  CHECK(state.publication_period_ns == 30'000'000);
  CHECK(state.snapshots == 2);
  CHECK(state.sphere_capacity == kMoving);
  CHECK(std::string(state.scene_name) == "three spheres");

  const auto fixed = reader.fixed(state);
  REQUIRE(fixed);
  CHECK(std::memcmp(fixed->materials.data(), fixture.materials.data(), sizeof fixture.materials) ==
        0);
  REQUIRE(fixed->planes.size() == 1);
  CHECK(std::memcmp(fixed->planes.data(), &fixture.plane, sizeof fixture.plane) == 0);
  CHECK(std::equal(fixed->tool_m.begin(), fixed->tool_m.end(), fixture.tool_m.begin(),
                   fixture.tool_m.end()));
  CHECK(fixed->place.device_position_m[2] == 0.5);
  CHECK(fixed->place.device_orientation_xyzw[3] == 1.0);
  CHECK(fixed->place.device_scale == 2.0);

  Spheres spheres(kMoving);
  REQUIRE(reader.snapshot(spheres));
  CHECK(spheres.count == kMoving);
  CHECK(spheres.snapshot_id == 2);
  CHECK(spheres.publish_time_ns >= spheres.state_time_ns);
  CHECK(are_alike(spheres.positions, positions_m(2)));
  CHECK(are_alike(spheres.velocities, kVelocities_m_s));
  CHECK(are_alike(spheres.radii, {kRadii_m.begin(), kRadii_m.end()}));
  CHECK(std::equal(kMaterials.begin(), kMaterials.end(), spheres.material_numbers.begin()));
  CHECK(std::equal(kBodies.begin(), kBodies.end(), spheres.body_numbers.begin()));

  Spheres still(state.static_count);
  REQUIRE(reader.static_spheres(still));
  CHECK(still.count == 2);
  CHECK(still.state_time_ns == 0);
  CHECK(are_alike(still.positions,
                  {fixture.static_positions_m.begin(), fixture.static_positions_m.end()}));
  CHECK(still.body_numbers == std::vector<std::uint32_t>{6, 7});
}

TEST_CASE("A reader sees a tick, and the spheres where that tick displayed them", "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  publish(publisher, 2);
  Reader reader(fixture.session.name().c_str());
  publication::ToolWriter writer(fixture.session.name(), 1'000'000, proto::Clock::kMonotonic, 0);
  const SessionState state = reader.poll();
  CHECK(state.is_felt == 1);
  CHECK(state.tick_period_ns == 1'000'000);
  CHECK_FALSE(reader.tool());  // no tick yet
  Spheres spheres(kMoving);
  CHECK_FALSE(reader.displayed(spheres));

  writer.publish(tick(7, state.scene_epoch, 2, 0.5));
  const auto tool = reader.tool();
  REQUIRE(tool);
  CHECK(tool->tick == 7);
  CHECK(tool->position_m[0] == 0.25);
  CHECK(tool->force_N[1] == 1.5);
  CHECK(tool->contacts == 3);
  CHECK(tool->snapshot_id == 2);
  CHECK(tool->age_s == 0.02);
  CHECK(std::isnan(tool->gripper_m));
  REQUIRE(reader.displayed(spheres));
  CHECK(spheres.positions[1] == 0.375F);  // half way from 0.25 to 0.5
  CHECK(std::isnan(spheres.velocities[0]));
  CHECK(spheres.radii[0] == 0.5F);

  publish(publisher, 3);  // which the tick does not display yet
  REQUIRE(reader.displayed(spheres));
  CHECK(spheres.positions[1] == 0.375F);  // the same place, told by the later history
  for (int n = 4; n < 8; ++n) publish(publisher, n);
  CHECK_FALSE(reader.displayed(spheres));  // it is forgotten
  writer.publish(tick(8, state.scene_epoch + 1, 7, 1.0));
  CHECK_FALSE(reader.displayed(spheres));  // of another simulation
}

/// What the logger prints of a session, a line.
std::string logged(const std::string& session) {
  const std::string command = STILLGRID_BINARY_DIR "/tests/library_logger " + session + " 1";
  FILE* lines = ::popen(command.c_str(), "r");
  REQUIRE(lines != nullptr);
  std::array<char, 256> line{};
  std::fgets(line.data(), static_cast<int>(line.size()), lines);
  CHECK(::pclose(lines) == 0);
  return line.data();
}

TEST_CASE("The logger of docs/library_reader.md tells what is published and felt", "[library]") {
  Fixture fixture;
  CHECK(logged(fixture.session.name()) == "nothing is published\n");
  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  CHECK(logged(fixture.session.name()) == "three spheres: snapshot 1 of 3 spheres\n");
  publication::ToolWriter writer(fixture.session.name(), 1'000'000, proto::Clock::kMonotonic, 0);
  writer.publish(tick(7, 1, 1, 1.0));
  CHECK(logged(fixture.session.name()) ==
        "three spheres: snapshot 1 of 3 spheres; 0.000 1.500 0.000 N\n");
}

TEST_CASE("An array too short takes as many spheres as fit, and of the fixed part nothing",
          "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  Reader reader(fixture.session.name().c_str());
  const SessionState state = reader.poll();

  Spheres spheres(kMoving);
  spheres.capacity = 2;
  spheres.radii[2] = -1.0F;
  REQUIRE(reader.snapshot(spheres));
  CHECK(spheres.count == kMoving);
  CHECK(spheres.radii[1] == 0.25F);
  CHECK(spheres.radii[2] == -1.0F);

  stillgrid_material material{-1.0, 0.0, 0.0};
  Sized<stillgrid_fixed> fixed;
  fixed.materials = &material;
  fixed.material_capacity = 1;
  fixed.device_scale = -1.0;
  CHECK(stillgrid_reader_fixed(reader.handle(), &fixed) == STILLGRID_E_CAPACITY);
  CHECK(std::string(stillgrid_last_error()).find("room for 1 materials") != std::string::npos);
  CHECK(material.stiffness_N_per_m == -1.0);
  CHECK(fixed.device_scale == -1.0);
  CHECK(state.material_count == 2);
}

TEST_CASE("Reading allocates nothing", "[library]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  Fixture fixture;
  Publisher publisher(fixture.scene);
  declare(publisher);
  publish(publisher, 1);
  publication::ToolWriter writer(fixture.session.name(), 1'000'000, proto::Clock::kMonotonic, 0);
  Spheres spheres(kMoving), still(2);
  Sized<stillgrid_snapshot> wrong;
  wrong.struct_size = 1;
  // The thread that watches for tools may allocate: the least of several tries is the readers' own.
  std::uint64_t least = ~0ULL;
  for (int tries = 0; tries < 50 && least > 0; ++tries) {
    const std::uint64_t at_first = *devices::allocation_count();
    Reader reader(fixture.session.name().c_str());
    const SessionState state = reader.poll();
    CHECK(*devices::allocation_count() > at_first);  // the library's are counted
    writer.publish(tick(7, state.scene_epoch, 1, 1.0));

    const std::uint64_t before = *devices::allocation_count();
    const bool are_read = reader.snapshot(spheres) && reader.displayed(spheres) &&
                          reader.static_spheres(still) && reader.tool();
    const int code = stillgrid_reader_snapshot(reader.handle(), &wrong);
    least = std::min(least, *devices::allocation_count() - before);

    CHECK(are_read);
    CHECK(code == STILLGRID_E_ARGUMENT);
  }
  CHECK(least == 0);
}

}  // namespace
}  // namespace stillgrid::library::reader_test

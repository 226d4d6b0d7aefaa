#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "haptic_server/recording/crc32.hpp"
#include "haptic_server/recording/mcap_messages.hpp"
#include "haptic_server/safety/safety_flag.hpp"

namespace stillgrid::recording::mcap_test {
namespace {

TEST_CASE("The checksum is the one that all know, and of parts that of the whole", "[mcap]") {
  static_assert(crc32("123456789") == 0xcbf43926);  // the check value of CRC-32/ISO-HDLC
  CHECK(crc32("") == 0);
  CHECK(crc32("6789", crc32("12345")) == 0xcbf43926);
}

TEST_CASE("A number that is none is left out, and the message is JSON all the same", "[mcap]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TickRow row;
  row.rendered_N = {1.0, nan, -0.0};
  row.age_s = std::numeric_limits<double>::infinity();
  row.position_m = {nan, nan, nan};
  row.flags = safety::kFlagRejected | safety::kFlagEnergy;
  std::string tick, pose, flags;
  write_tick(row, tick);
  write_pose(row, 1'500'000'000, pose);
  write_flags(row.flags, flags);
  const auto told = nlohmann::json::parse(tick);
  CHECK(told.at("rendered_force_N") == nlohmann::json({{"x", 1.0}, {"z", -0.0}}));
  CHECK_FALSE(told.contains("age_s"));
  CHECK(told.at("flags") == "rejected|energy");
  const auto placed = nlohmann::json::parse(pose);
  CHECK(placed.at("timestamp") == nlohmann::json({{"sec", 1}, {"nsec", 500'000'000}}));
  CHECK(placed.at("translation").empty());
  const auto set = nlohmann::json::parse(flags);
  CHECK(set.size() == safety::kSafetyFlagNames.size());
  CHECK((set.at("rejected") == true && set.at("energy") == true && set.at("faded") == false));
}

TEST_CASE("A scene's spheres are an entity a body, in place of those before", "[mcap]") {
  const SampledSpheres sampled{
      {{{0.0F, 1.0F, 2.0F}, 0.5F, 3}, {{1.0F, 1.0F, 1.0F}, 0.1F, 0}, {{2.0F, 1.0F, 2.0F}, 0.5F, 3}},
      9};
  std::string json;
  write_spheres(sampled, 7, json);
  const auto update = nlohmann::json::parse(json);
  CHECK(update.at("deletions").at(0).at("type") == 1);
  const auto& entities = update.at("entities");
  REQUIRE(entities.size() == 2);
  CHECK(entities.at(0).at("id") == "body 0");
  CHECK(entities.at(1).at("id") == "body 3");
  CHECK(entities.at(1).at("metadata").at(0).at("value") == "9");
  REQUIRE(entities.at(1).at("spheres").size() == 2);
  CHECK(entities.at(1).at("spheres").at(1).at("pose").at("position").at("x") == 2.0);
  CHECK(entities.at(1).at("spheres").at(1).at("size").at("z") == 1.0);
}

TEST_CASE("A plane's square lies on the plane, its normal that of the solid below", "[mcap]") {
  FixedScene scene;
  scene.planes = {{{0.0F, 1.0F, 0.0F}, -0.1F, 0, 4}, {{0.0F, 0.0F, -1.0F}, 0.2F, 0, 5}};
  std::string json;
  write_fixed(scene, 7, json);
  const auto entities = nlohmann::json::parse(json).at("entities");
  REQUIRE(entities.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& cube = entities.at(i).at("cubes").at(0);
    const auto& at = cube.at("pose").at("position");
    const auto& q = cube.at("pose").at("orientation");
    const Eigen::Vector3d centre_m(at.at("x"), at.at("y"), at.at("z"));
    const Eigen::Quaterniond turn(q.at("w"), q.at("x"), q.at("y"), q.at("z"));
    const Eigen::Vector3d normal = Eigen::Vector3f(scene.planes[i].normal.data()).cast<double>();
    const Eigen::Vector3d top_m =
        centre_m + turn * Eigen::Vector3d(0.0, 0.0, cube.at("size").at("z").get<double>() / 2.0);
    CHECK(normal.dot(top_m) == Approx(scene.planes[i].offset_m).margin(1e-6));
    CHECK((turn * Eigen::Vector3d::UnitZ()).isApprox(normal, 1e-6));
  }
}

}  // namespace
}  // namespace stillgrid::recording::mcap_test

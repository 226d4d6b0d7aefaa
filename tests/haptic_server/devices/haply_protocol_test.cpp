#include "haptic_server/devices/haply_protocol.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "proto/device_plugin.h"

namespace stillgrid::devices::haply_protocol_test {
namespace {

/// As service 3.4.8 sent it [comments of SofaHaplyRobotics], shortened by what nobody reads.
const std::string kOf34 =
    R"({"inverse3":[{"device_id":"04EA","state":{"angular_position":{"a0":-30.9,"a1":53.8,"a2":-6.6},)"
    R"("current_cursor_force":{"x":0,"y":0,"z":1.5},)"
    R"("cursor_position":{"x":0.10428079,"y":-0.03648221,"z":-0.06100729},)"
    R"("cursor_velocity":{"x":0,"y":0.25,"z":0},"mode":"idle","transform":{"position":{"x":0,"y":0,)"
    R"("z":0},"rotation":{"w":1,"x":0,"y":0,"z":0},"scale":{"x":1,"y":1,"z":1}}},"status":{)"
    R"("calibrated":true,"in_use":false,"power_supply":true,"ready":true,"started":true}}],)"
    R"("verse_grip":[{"device_id":"61576","state":{"button":true,"hall":1,"orientation":)"
    R"({"w":0.71655273,"x":0.19647217,"y":0.6290283,"z":-0.22833252}}}]})";

/// The same with what a test puts elsewhere.
std::string changed(const std::string& from, const std::string& to) {
  const std::size_t place = kOf34.find(from);
  REQUIRE(place != std::string::npos);
  return std::string(kOf34).replace(place, from.size(), to);
}

std::string refusal(const std::string& text) {
  try {
    (void)read_haply_message(text);
  } catch (const HaplyProtocolError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("A state update of 3.4 is read as it stands", "[haply]") {
  const HaplyMessage message = read_haply_message(kOf34);
  REQUIRE(message.arms.size() == 1);
  const HaplyArm& arm = message.arms[0];
  CHECK(arm.id == "04EA");
  CHECK(arm.position_m == Eigen::Vector3d(0.10428079, -0.03648221, -0.06100729));
  CHECK(arm.velocity_m_s == Eigen::Vector3d(0.0, 0.25, 0.0));
  CHECK(arm.force_N.value() == Eigen::Vector3d(0.0, 0.0, 1.5));
  CHECK(arm.foreign_frame.empty());
  CHECK(arm.spelling == HaplySpelling::kValues);
  CHECK(arm.status == (STILLGRID_STATUS_CALIBRATED | STILLGRID_STATUS_MOTORS_ON));
  REQUIRE(message.grip("61576") != nullptr);
  const HaplyGrip& grip = *message.grip("61576");
  CHECK(grip.orientation.value().w() == Approx(0.71655273).epsilon(1e-3));
  CHECK(grip.button_count == 1);
  CHECK(grip.buttons == 1);
}

TEST_CASE("An inventory of 3.5 tells the firmware, the name of a force and a foreign frame",
          "[haply]") {
  const auto with = [](const std::string& config) {
    return read_haply_message(changed(R"("state":)", R"("config":{)" + config + R"(},"state":)"))
        .arms[0];
  };
  const HaplyArm own = with(R"("type":"inverse3","basis":{"permutation":"XYZ"},)"
                            R"("device_info":{"major_version":7,"minor_version":4})");
  CHECK(own.spelling == HaplySpelling::kVector);
  CHECK(own.firmware == "7.4");
  CHECK(own.foreign_frame.empty());
  CHECK(with(R"("basis":{"permutation":"XZY"})").foreign_frame == "the basis XZY");
  CHECK(with(R"("mount":{"position":{"x":0.1,"y":0,"z":0}})").foreign_frame == "a mount");
  // 120 degrees, told by a quaternion twice as long as a unit.
  CHECK(with(R"("mount":{"rotation":{"w":1,"x":1,"y":1,"z":1}})").foreign_frame == "a mount");
  CHECK(with(R"("mount":{"rotation":{"w":-2,"x":0,"y":0,"z":0}})").foreign_frame.empty());
  CHECK(with(R"("extended_firmware_version":"7\n\u00e4")").firmware == "7???");
}

TEST_CASE("What is of no use is refused by its place", "[haply]") {
  CHECK(refusal("").find("a JSON object") != std::string::npos);
  CHECK(refusal("[]").find("a JSON object") != std::string::npos);
  CHECK(refusal(changed(R"("z":1.5)", R"("z":"1.5")")).find("current_cursor_force.z") !=
        std::string::npos);
  CHECK(refusal(changed("0.10428079", "1e3")).find("cursor_position.x: expected a number") !=
        std::string::npos);
  CHECK(refusal(changed("0.10428079", "1e999")).find("a JSON object") != std::string::npos);
  CHECK(refusal(changed("0.10428079", "null")).find("cursor_position.x") != std::string::npos);
  CHECK(refusal(changed(R"("04EA")", R"("04\"EA")")).find("device_id") != std::string::npos);
  CHECK(refusal(changed(R"("04EA")", "1258")).find("inverse3[0].device_id") != std::string::npos);
  CHECK(refusal(changed(R"("calibrated":true)", R"("calibrated":1)")).find("true or false") !=
        std::string::npos);
  CHECK(refusal(R"({"inverse3":{}})").find("a list") != std::string::npos);
  CHECK(refusal(std::string(100'000, ' ')).find("64 KiB") != std::string::npos);
  CHECK(refusal("{\"a\":" + std::string(1000, '[')).find("nesting") != std::string::npos);
  CHECK(refusal(changed(R"("verse_grip")", R"("inverse3")")).find("inverse3") != std::string::npos);
}

TEST_CASE("Whatever bytes come, a message is refused in one line or has finite figures",
          "[haply]") {
  for (unsigned seed = 0; seed < 20'000; ++seed) {
    std::mt19937 random(seed);
    std::string text = kOf34;
    for (auto changes = 1 + random() % 6; changes > 0; --changes) {
      const std::size_t place = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[place] = static_cast<char>(random() % 256);
          break;
        case 1:
          text.erase(place, random() % 40);
          break;
        case 2:
          text.insert(place, text.substr(random() % text.size(), random() % 40));
          break;
        default: {
          static const std::vector<std::string> kStrangers = {
              "1e308", "-1e400", "NaN", "null", "{}", "[]", "\"", "9", "-", "\\u0000", "true"};
          text.insert(place, kStrangers[random() % kStrangers.size()]);
        }
      }
      if (text.empty()) text = "{";
    }
    INFO("seed " << seed << ": " << text);
    try {
      for (const HaplyArm& arm : read_haply_message(text).arms) {
        REQUIRE(is_haply_id(arm.id));
        REQUIRE(arm.position_m.allFinite());
        REQUIRE(arm.position_m.cwiseAbs().maxCoeff() <= 10.0);
        REQUIRE(arm.velocity_m_s.allFinite());
        REQUIRE((!arm.force_N || arm.force_N->allFinite()));
      }
    } catch (const HaplyProtocolError& error) {
      REQUIRE(std::string(error.what()).find('\n') == std::string::npos);
    }
  }
}

TEST_CASE("A force is written as the service's documents have it, whatever it is", "[haply]") {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-5.0, 5.0);
    const Eigen::Vector3d force_N(number(random), number(random), number(random));
    const bool is_vector = seed % 2 == 0;
    std::string text = "what was there before";
    write_haply_force(text, "049D", is_vector ? HaplySpelling::kVector : HaplySpelling::kValues,
                      force_N);
    const auto value = nlohmann::json::parse(text);
    const auto& device = value["inverse3"].at(0);
    CHECK(device["device_id"] == "049D");
    const auto& told = device["commands"]["set_cursor_force"].at(is_vector ? "vector" : "values");
    CHECK(told["x"].get<double>() == Approx(force_N.x()).margin(1e-6));
    CHECK(told["y"].get<double>() == Approx(force_N.y()).margin(1e-6));
    CHECK(told["z"].get<double>() == Approx(force_N.z()).margin(1e-6));
  }
}

}  // namespace
}  // namespace stillgrid::devices::haply_protocol_test

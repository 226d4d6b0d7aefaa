#include "haptic_server/device/device_spec.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

namespace stillgrid::device::device_spec_test {
namespace {

TEST_CASE("A device is a plugin and its options, in order", "[device_spec]") {
  const DeviceSpec spec = parse_device_spec(
      "replay:file=/data/a:b=c.csv,map=x_m:slave_rad*0.075;y_m:b,offset_x_m=-1.5,note=");
  CHECK(spec.plugin == "replay");
  REQUIRE(spec.options.size() == 4);
  CHECK(spec.options[0].key == "file");
  CHECK(spec.options[0].value == "/data/a:b=c.csv");
  CHECK(spec.options[1].value == "x_m:slave_rad*0.075;y_m:b");
  CHECK(spec.options[3].value.empty());
  CHECK(parse_device_spec("/opt/drivers/touch.so").plugin == "/opt/drivers/touch.so");
  CHECK(parse_device_spec("phantom").options.empty());
}

TEST_CASE("A device that cannot be meant is bad input", "[device_spec]") {
  for (const char* const text : {"", ":a=b", "phantom:", "phantom:a", "phantom:=b", "phantom:a=b,",
                                 "phantom:a=b,,c=d", "phantom:a=b,a=c"}) {
    INFO(text);
    try {
      static_cast<void>(parse_device_spec(text));
      FAIL("accepted");
    } catch (const DeviceError& error) {
      CHECK(error.exit_status() == 1);
      CHECK(std::string(error.what()).find("expected") != std::string::npos);
    }
  }
}

TEST_CASE("An installed plugin is found by name, any other by its path", "[device_spec]") {
  setenv("STILLGRID_DEVICE_PATH", "/nowhere::" STILLGRID_PLUGIN_DIR, 1);
  CHECK(find_device_plugin("phantom") == STILLGRID_PLUGIN_DIR "/phantom.so");
  CHECK(find_device_plugin(STILLGRID_PLUGIN_DIR "/replay.so").is_absolute());
  CHECK_THROWS_WITH(find_device_plugin("omega"),
                    Catch::Contains("'omega'") && Catch::Contains(STILLGRID_PLUGIN_DIR));
  CHECK_THROWS_WITH(find_device_plugin("./phantom.so"), Catch::Contains("no such file"));
  CHECK_THROWS_AS(find_device_plugin("/tmp"), DeviceError);
  unsetenv("STILLGRID_DEVICE_PATH");
}

}  // namespace
}  // namespace stillgrid::device::device_spec_test

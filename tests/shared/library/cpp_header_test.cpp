#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <utility>

#include "tests/shared/library/published_session.hpp"

namespace stillgrid::library::cpp_header_test {
namespace {

TEST_CASE("An Error carries the code and the line of the call that failed", "[library]") {
  Fixture fixture;
  fixture.scene.period_s = -1.0;
  try {
    const Publisher publisher(fixture.scene);
    FAIL("a period below 0 was taken");
  } catch (const Error& error) {
    CHECK(error.code() == STILLGRID_E_ARGUMENT);
    CHECK(std::string(error.what()) == stillgrid_last_error());
    CHECK(std::string(error.what()).find("scene.period_s: -1") != std::string::npos);
  }
}

TEST_CASE("Arrays that differ in length are refused before the call", "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  declare(publisher);
  const std::array<double, 2> two{};
  CHECK(code_of([&] { publisher.set_spheres(positions_m(0), two); }) == STILLGRID_E_ARGUMENT);
  CHECK(code_of([&] { publisher.set_spheres(two); }) == STILLGRID_E_ARGUMENT);
  CHECK(code_of([&] { publisher.set_shapes(Shapes(kRadii_m, std::span(kMaterials).first(1))); }) ==
        STILLGRID_E_ARGUMENT);
}

TEST_CASE("A session ends with its publisher, wherever that was moved", "[library]") {
  Fixture fixture;
  Reader reader(fixture.session.name().c_str());
  {
    Publisher first(fixture.scene);
    CHECK(code_of([&] { const Publisher second(fixture.scene); }) == STILLGRID_E_SESSION);
    const Publisher moved = std::move(first);
    CHECK(reader.poll().is_published == 1);
  }
  CHECK(reader.poll().is_published == 0);
}

TEST_CASE("Steps of a publisher come in their order", "[library]") {
  Fixture fixture;
  Publisher publisher(fixture.scene);
  std::array<stillgrid_push, 4> room{};
  CHECK(code_of([&] { publisher.publish(); }) == STILLGRID_E_ORDER);
  CHECK(code_of([&] { publisher.set_spheres(positions_m(0)); }) == STILLGRID_E_ORDER);
  CHECK(code_of([&] { publisher.pushes(0.01, room); }) == STILLGRID_E_ORDER);
  declare(publisher);
  CHECK(code_of([&] { publisher.publish(); }) == STILLGRID_E_ORDER);
  publisher.set_spheres(positions_m(0));
  CHECK(publisher.pushes(0.01, room).empty());  // no hand is there
  CHECK_FALSE(publisher.tool());
  CHECK(publisher.publish());
  REQUIRE(publisher.wait());
}

}  // namespace
}  // namespace stillgrid::library::cpp_header_test

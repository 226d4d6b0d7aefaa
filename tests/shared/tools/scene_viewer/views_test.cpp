#include "shared/tools/scene_viewer/views.hpp"

#include <catch2/catch.hpp>

#include "tests/shared/publication/small_scene.hpp"

namespace stillgrid::scene_viewer::views_test {
namespace {

TEST_CASE("A session that runs is found by its name, and none that does not", "[views]") {
  const publication::TestSession session;
  LiveOptions options;
  Views views(options);
  CHECK(views.named().empty());
  CHECK_FALSE(views.find(""));
  CHECK_FALSE(views.find(session.name()));
  for (const char* name : {"/", "../a", "+", "a+", "a b", "1/2/3"}) CHECK_FALSE(views.find(name));

  publication::SmallSceneWriter writer(session);
  writer.publish_next();
  const auto view = views.find(session.name());
  REQUIRE(view);
  CHECK(view->status().live);
  CHECK(views.find(session.name()) == view);
  CHECK_FALSE(views.find(""));
}

TEST_CASE("Of sessions beside the named one three are held, those asked for last", "[views]") {
  const publication::TestSession first, second, third, fourth;
  LiveOptions options;
  options.session = "views-test-named";
  Views views(options);
  const auto named = views.find("");
  REQUIRE(named);
  std::vector<std::unique_ptr<publication::SmallSceneWriter>> writers;
  std::vector<std::weak_ptr<const ViewSource>> held;
  for (const auto* session : {&first, &second, &third, &fourth}) {
    writers.push_back(std::make_unique<publication::SmallSceneWriter>(*session));
    writers.back()->publish_next();
    held.push_back(views.find(session->name()));
    CHECK_FALSE(held.back().expired());
    CHECK(views.find(first.name()));  // that one is looked at all the time
  }
  CHECK_FALSE(held[0].expired());
  CHECK(held[1].expired());
  CHECK_FALSE(held[2].expired());
  CHECK_FALSE(held[3].expired());
  CHECK(views.find("views-test-named") == named);
}

}  // namespace
}  // namespace stillgrid::scene_viewer::views_test

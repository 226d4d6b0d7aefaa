#include "shared/rendering/renderer.hpp"

#include <catch2/catch.hpp>
#include <utility>

#include "tests/shared/rendering/scene_fixture.hpp"

namespace stillgrid::rendering::renderer_test {
namespace {

TEST_CASE("There is no force before a snapshot was read whole, by any transition", "[renderer]") {
  for (const display::TransitionLaw& law : display::transitions()) {
    INFO(law.name);
    publication::StaticScene ground = plain_scene(500.0F, 0.1F);
    ground.planes = {{.normal = {0.0F, 0.0F, 1.0F}, .offset_m = 0.0F, .material = 0, .body = 0}};
    PublishedScene scene(ground, {0.1F}, kMillisecond_ns);
    const std::unique_ptr<Renderer> renderer = make_renderer(*display::transition_named(law.name));
    const ToolPose pressed{.position_m = {0.0, 0.0, 0.09}};
    scene.show({{0.0, 0.0, 0.0}}, 0);
    std::uint64_t& sequence = *scene.writer().segment().buffer().sequence[1];
    const std::uint64_t whole = std::exchange(sequence, 1);  // being written

    const RenderedTick before = renderer->render(scene.view(), pressed, kMillisecond_ns);
    CHECK(before.contended);
    CHECK(before.snapshot_id == 0);
    CHECK(before.force.force_N.isZero(0.0));
    CHECK(before.force.contacts == 0);
    CHECK(before.age_s == 0.0);

    sequence = whole;
    const RenderedTick after = renderer->render(scene.view(), pressed, 2 * kMillisecond_ns);
    CHECK(after.is_new);
    CHECK(after.force.force_N.z() > 1.0);
  }
}

}  // namespace
}  // namespace stillgrid::rendering::renderer_test

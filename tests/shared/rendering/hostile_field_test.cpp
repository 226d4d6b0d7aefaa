// Fields of a segment whose slots lie.

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "shared/rendering/renderer.hpp"
#include "shared/rendering/snapshot_renderer.hpp"
#include "shared/rendering/touched_fields.hpp"
#include "tests/haptic_server/devices/allocation_counter.hpp"
#include "tests/sanitizer_cut.hpp"
#include "tests/shared/rendering/field_fixture.hpp"

namespace stillgrid::rendering::hostile_field_test {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kPeriod_ns = 30 * kMillisecond_ns;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

publication::StaticScene fixture() {
  return moving_field(plain_scene(700.0F, 0.005F), ball_field(0.02));
}
constexpr double kTouching_m = 0.023;

/// What a tool feels that touches a ball whose record was spoilt.
template <class Spoil>
std::vector<RenderedTick> felt_when(Spoil&& spoil) {
  PublishedScene scene(fixture(), {}, kPeriod_ns);
  scene.fields.resize(1);
  collision::fill_history(scene.fields[0], field_state({}));
  spoil(scene.fields[0]);
  scene.show({}, kPeriod_ns);
  std::vector<RenderedTick> ticks;
  for (const display::TransitionLaw& law : display::transitions()) {
    const auto renderer = make_renderer(law.transition);
    for (std::uint64_t ms = 0; ms < 40; ms += 13)
      ticks.push_back(renderer->render(scene.view(), {.position_m = {0.0, 0.0, kTouching_m}},
                                       kPeriod_ns + ms * kMillisecond_ns));
  }
  return ticks;
}
template <class Spoil>
bool is_left_out(Spoil&& spoil) {
  const auto ticks = felt_when(spoil);
  return std::all_of(ticks.begin(), ticks.end(), [](const RenderedTick& tick) {
    return tick.force.contacts == 0 && tick.force.force_N.isZero();
  });
}

}  // namespace

TEST_CASE("A field whose place is none is left out of the tick", "[hostile_field]") {
  CHECK_FALSE(is_left_out([](auto&) {}));
  for (const float bad : {kNaN, INFINITY, -INFINITY, 2e6F}) {
    CHECK(is_left_out([&](auto& record) { record.history[0].position_m[1] = bad; }));
    CHECK(is_left_out([&](auto& record) { record.history[0].orientation_xyzw[2] = bad; }));
    CHECK(is_left_out([&](auto& record) { record.history[0].velocity_m_s[0] = bad; }));
    CHECK(is_left_out([&](auto& record) { record.history[0].angular_velocity_rad_s[0] = bad; }));
  }
  CHECK(is_left_out([](auto& record) { record.history[0].orientation_xyzw = {}; }));
  CHECK(is_left_out([](auto& record) { record.history[0].orientation_xyzw[3] = 1.01F; }));
}

TEST_CASE("Words of any kind in a slot make no force that is none, and no tick without a bound",
          "[hostile_field]") {
  std::mt19937 random(GENERATE(range(1U, tests::seeds_end(6))));
  publication::StaticScene fixed = fixture();
  for (int i = 0; i < 20; ++i) fixed = moving_field(fixed, fixed.fields[0].field);
  fixed.tool.assign(16, fixed.tool[0]);
  PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.fields.resize(fixed.fields.size());
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const display::TransitionLaw& law : display::transitions())
    renderers.push_back(make_renderer(law.transition));
  int touched = 0;
  for (std::uint64_t n = 1; n <= 40; ++n) {
    for (proto::FieldRecord& record : scene.fields) {
      collision::push_snapshot(record, field_state({}));
      // Most words as they were: what is refused at once tries nothing else.
      auto words = std::bit_cast<std::array<std::uint32_t, sizeof(record) / 4>>(record);
      for (std::uint32_t& word : words)
        if (random() % 60 == 0)
          word = random() % 2 == 0 ? static_cast<std::uint32_t>(random())
                                   : std::bit_cast<std::uint32_t>(0.3F);
      record = std::bit_cast<proto::FieldRecord>(words);
    }
    scene.show({}, n * kPeriod_ns);
    for (std::uint64_t ms = 0; ms < 30; ms += 7)
      for (const auto& renderer : renderers) {
        const RenderedTick tick =
            renderer->render(scene.view(), {.position_m = {0.0, 0.0, kTouching_m}},
                             n * kPeriod_ns + ms * kMillisecond_ns);
        CHECK(tick.force.force_N.allFinite());
        CHECK(tick.force.torque_N_m.allFinite());
        CHECK(tick.force.contacts <= static_cast<int>(TouchedSpheres::kCapacity));
        touched += tick.force.contacts;
      }
  }
  CHECK(touched > 1000);
}

TEST_CASE("More contacts than a tick keeps are told, as is more work", "[hostile_field]") {
  publication::StaticScene fixed = plain_scene(700.0F, 0.005F);
  const Field field = ball_field(0.02);
  for (std::uint32_t i = 0; i < proto::kMaxFields; ++i) fixed = still_field(fixed, field, {});
  fixed.tool.assign(proto::kMaxToolSpheres, fixed.tool[0]);
  PublishedScene scene(fixed, {}, kPeriod_ns);
  scene.show({}, kPeriod_ns);
  SnapshotRenderer renderer(display::Transition::kHold);
  const auto render = [&](double height_m) {
    return renderer.render(scene.view(), {.position_m = {0.0, 0.0, height_m}}, kPeriod_ns);
  };
  const RenderedTick many = render(0.023);
  CHECK(many.truncated);
  CHECK(many.force.contacts == static_cast<int>(TouchedSpheres::kCapacity));
  CHECK_FALSE(render(0.5).truncated);
}

TEST_CASE("A tick that meets fields allocates nothing, at a switch neither", "[hostile_field]") {
  if (!devices::allocation_count()) {
    WARN("skipped: only the address sanitizer counts allocations");
    return;
  }
  const auto transition = GENERATE(display::Transition::kLinear, display::Transition::kLocal);
  PublishedScene scene(still_field(fixture(), box_field({0.02, 0.02, 0.001}), {}), {}, kPeriod_ns);
  scene.fields.resize(1);
  const auto renderer = make_renderer(transition);
  int contacts = 0;
  std::uint64_t allocations = 0;
  for (std::uint64_t n = 1; n <= 4; ++n) {
    collision::push_snapshot(scene.fields[0], field_state({}));
    scene.show({}, n * kPeriod_ns);
    const auto before = devices::allocation_count();
    for (std::uint64_t ms = 0; ms < 30; ++ms)
      contacts += renderer
                      ->render(scene.view(),
                               {.position_m = {0.0, 0.0, ms % 5 == 0 ? -kTouching_m : kTouching_m}},
                               n * kPeriod_ns + ms * kMillisecond_ns)
                      .force.contacts;
    allocations += *devices::allocation_count() - *before;
  }
  CHECK(contacts > 100);
  CHECK(allocations == 0);
}

}  // namespace stillgrid::rendering::hostile_field_test

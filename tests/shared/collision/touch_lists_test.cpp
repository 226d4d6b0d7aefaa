#include "shared/collision/touch_lists.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/shared/collision/random_scene.hpp"
#include "tests/shared/collision/sphere_state.hpp"

namespace stillgrid::collision::touch_lists_test {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<proto::SphereRecord> records_of(const RandomScene& scene) {
  std::vector<proto::SphereRecord> records;
  for (const SweptBound& ball : scene.swept_bounds) {
    records.push_back(static_sphere(ball.centre_m, ball.bounding_radius_m));
    records.back().material = static_cast<std::uint32_t>(7 * records.size());
    records.back().body = static_cast<std::uint32_t>(3 * records.size());
  }
  return records;
}

/// The lists of some spheres, and a view of them.
struct Lists {
  explicit Lists(std::vector<proto::SphereRecord> spheres, float probe_radius_m)
      : records(std::move(spheres)),
        lists(records, probe_radius_m),
        view(lists.shape(), static_cast<std::uint32_t>(records.size()), lists.words().data()) {}
  std::vector<proto::SphereRecord> records;
  TouchLists lists;
  TouchView view;
};

std::vector<TouchEntry> found_by(const TouchView& view, const SweptBound& probe) {
  std::vector<TouchEntry> found;
  const bool was_truncated = view.for_each_touch(
      probe, kAllVisits, [&](const TouchEntry& entry) { found.push_back(entry); });
  REQUIRE_FALSE(was_truncated);
  return found;
}

/// What queries answered, against every sphere tried in turn.
struct Answers {
  std::size_t touching = 0, missed = 0, twice = 0, idle = 0, untrue = 0;

  void compare(const Lists& all, const SweptBound& probe) {
    std::vector<int> visits(all.records.size(), 0);
    for (const TouchEntry& entry : found_by(all.view, probe)) {
      const proto::SphereRecord& record = all.records[entry.label.number];
      ++visits[entry.label.number];
      untrue += entry.centre_m == record.newest.position_m && entry.radius_m == record.radius_m &&
                        entry.label.material == record.material && entry.label.body == record.body
                    ? 0U
                    : 1U;
    }
    for (std::size_t i = 0; i < visits.size(); ++i) {
      const proto::SphereRecord& record = all.records[i];
      const SweptBound sphere{record.newest.position_m, record.radius_m};
      const bool meets = meet_exactly(sphere, probe);
      touching += meets ? 1U : 0U;
      missed += meets && visits[i] == 0 ? 1U : 0U;
      twice += visits[i] > 1 ? 1U : 0U;
      // Rounding may let in a sphere that all but touches.
      SweptBound larger = probe;
      larger.bounding_radius_m += 1e-5F * (larger.bounding_radius_m + record.radius_m);
      idle += visits[i] > 0 && !meet_exactly(sphere, larger) ? 1U : 0U;
    }
  }
};

/// A probe as large as lists serve or less: at a sphere, on its surface or beside it, or exactly on
/// a border of voxels near it.
SweptBound probe_near(const Lists& all, std::mt19937_64& random) {
  std::uniform_real_distribution<float> share(-1.0F, 1.0F);
  const proto::SphereRecord& record = all.records[random() % all.records.size()];
  const float probe_radius_m = all.view.probe_radius_m();
  SweptBound probe{record.newest.position_m,
                   random() % 2 ? probe_radius_m : probe_radius_m * std::abs(share(random))};
  const float away_m = record.radius_m + probe.bounding_radius_m;
  const proto::TouchShape& shape = all.lists.shape();
  const float voxel_m = shape.levels[random() % shape.level_count].voxel_m;
  const bool is_on_border = random() % 3 == 0;
  for (float& x_m : probe.centre_m) {
    x_m += share(random) * away_m;
    if (is_on_border) x_m = std::round(x_m / voxel_m) * voxel_m;
    if (is_on_border && random() % 3 == 0) x_m = std::nextafter(x_m, -kInfinity);
  }
  return probe;
}

float probe_radius_for(SceneKind kind, std::uint64_t seed) {
  constexpr std::array kProbes_m{0.002F, 0.0113F, 1.0F / 64.0F, 0.07F};
  return (kind == SceneKind::kFarAway ? 10.0F : 1.0F) * kProbes_m[seed % kProbes_m.size()];
}

TEST_CASE("Every static sphere that a probe touches is found in its lists exactly once",
          "[touch_lists]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  Answers answers;
  std::size_t probes = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Lists all(records_of(random_scene(kind, seed)), probe_radius_for(kind, seed));
    REQUIRE(is_consistent(all.lists.shape()));
    std::mt19937_64 random(seed);
    for (std::size_t i = 0; i < 40; ++i, ++probes) answers.compare(all, probe_near(all, random));
  }
  CHECK(answers.missed == 0);
  CHECK(answers.twice == 0);
  CHECK(answers.idle == 0);
  CHECK(answers.untrue == 0);
  CHECK(answers.touching > probes / 2);  // the scenes are not idle
}

TEST_CASE("In a scene of 50,000 static spheres too each one is found exactly once",
          "[touch_lists]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  const Lists all(records_of(random_scene(kind, 5, 50000)), probe_radius_for(kind, 2));
  std::mt19937_64 random(1);
  Answers answers;
  for (int i = 0; i < 50; ++i) answers.compare(all, probe_near(all, random));
  CHECK(answers.missed == 0);
  CHECK(answers.twice == 0);
  CHECK(answers.idle == 0);
  CHECK(answers.touching > 20);
}

TEST_CASE("Whatever the radii, a sphere is in 64 lists at most, and cells are paid for",
          "[touch_lists]") {
  const auto kind = static_cast<SceneKind>(GENERATE(range(0, static_cast<int>(SceneKind::kCount))));
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Lists all(records_of(random_scene(kind, seed)), probe_radius_for(kind, seed));
    const proto::TouchShape& shape = all.lists.shape();
    CHECK(shape.cell_count <= 8 * all.records.size() + 64 * std::size_t{shape.level_count});
    CHECK(all.lists.words().size() == touch_words(shape));
    std::vector<int> lists(all.records.size(), 0);
    const std::uint64_t* const words = all.lists.words().data();
    std::size_t idle = 0;
    for (std::size_t cell = 0; cell < shape.cell_count; ++cell) {
      const std::uint32_t first = double_buffer::load_u32(words, cell);
      const std::uint32_t count = double_buffer::load_u32(words, cell + 1) - first;
      REQUIRE(count % 2 == 0);
      const auto* const labels = reinterpret_cast<const proto::TouchLabel*>(
          words + touch_entry_word(shape) + kTouchEntryWords * first + 2 * count);
      for (std::uint32_t i = 0; i < count; ++i)
        if (labels[i].number < lists.size())
          ++lists[labels[i].number];
        else
          ++idle;
    }
    CHECK(idle <= shape.cell_count);
    if (!lists.empty()) {
      CHECK(*std::min_element(lists.begin(), lists.end()) >= 1);
      CHECK(*std::max_element(lists.begin(), lists.end()) <= 64);
    }
  }
}

TEST_CASE("A static sphere that is nowhere is in no list, and the others are in theirs",
          "[touch_lists]") {
  std::vector<proto::SphereRecord> records =
      records_of(random_scene(SceneKind::kScattered, 7, 200));
  for (std::size_t i = 0; i < records.size(); i += 3) records[i].newest.position_m[i % 3] = kNaN;
  const Lists all(records, 0.01F);
  std::mt19937_64 random(2);
  Answers answers;
  for (int i = 0; i < 500; ++i) {
    const SweptBound probe = probe_near(all, random);
    if (!std::isnan(probe.centre_m[0] + probe.centre_m[1] + probe.centre_m[2]))
      answers.compare(all, probe);
  }
  CHECK(answers.missed == 0);
  CHECK(answers.idle == 0);
  CHECK(answers.touching > 100);

  const Lists nothing({}, 0.01F);
  CHECK(is_consistent(nothing.lists.shape()));
  CHECK(found_by(nothing.view, {{0.0F, 0.0F, 0.0F}, 0.01F}).empty());
}

TEST_CASE("Touch lists of random words never lead outside them and their visits are bounded",
          "[touch_lists]") {
  constexpr std::uint32_t kSpheres = 40, kMaxVisits = 50;
  std::mt19937_64 random(1);
  std::size_t cut = 0, visited = 0, out_of_range = 0, over_limit = 0;
  for (int round = 0; round < 6000; ++round) {
    proto::TouchShape shape{};
    shape.cell_count = static_cast<std::uint32_t>(random() % 600);
    shape.entry_count = static_cast<std::uint32_t>(random() % 300);
    shape.probe_radius_m = 0.015F;
    shape.level_count = static_cast<std::uint32_t>(random() % 4);
    for (std::uint32_t i = 0; i < shape.level_count; ++i) {
      proto::GridLevel& level = shape.levels[i];
      level.voxel_m = random() % 4 ? 0.01F : 1e-30F;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        level.cells[axis] = 1U << (random() % 4);
        const bool is_extreme = random() % 4 == 0;
        level.lowest_voxel[axis] = is_extreme ? std::numeric_limits<std::int32_t>::min() : -2;
        level.highest_voxel[axis] = is_extreme ? std::numeric_limits<std::int32_t>::max() : 3;
      }
      level.first_cell = static_cast<std::uint32_t>(random() % 100);
    }
    if (!is_consistent(shape)) continue;
    // In a block of the exact size, so that the address sanitizer sees one word too far.
    std::vector<std::uint64_t> words(touch_words(shape));
    constexpr std::uint64_t kSmall = 0x0000007F0000007FULL;
    for (std::size_t word = 0; word < words.size(); ++word) {
      const bool is_small = round % 3 == 0 || (round % 3 == 1 && word < touch_entry_word(shape));
      words[word] = random() & (is_small ? kSmall : ~std::uint64_t{0});
    }
    const TouchView view(shape, kSpheres, words.data());
    const float radius_m = round % 8 ? 0.015F : kInfinity;
    const float place_m = round % 16 ? 0.005F : kNaN;
    std::size_t visits = 0;
    const bool was_truncated = view.for_each_touch(
        {{place_m, 0.005F, 0.0F}, radius_m}, kMaxVisits, [&](const TouchEntry& entry) {
          ++visits;
          out_of_range += entry.label.number < kSpheres ? 0U : 1U;
        });
    cut += was_truncated ? 1U : 0U;
    visited += visits;
    over_limit += visits > kMaxVisits ? 1U : 0U;
  }
  CHECK(out_of_range == 0);
  CHECK(over_limit == 0);
  CHECK(cut > 0);
  CHECK(visited > 0);
}

TEST_CASE("A look into touch lists that is cut short says so, and one that is not is whole",
          "[touch_lists]") {
  const Lists all(records_of(random_scene(SceneKind::kCoincident, 5, 250)), 0.05F);
  const SweptBound probe{{0.0371F, 0.0F, 0.0F}, 0.05F};
  const std::size_t whole = found_by(all.view, probe).size();
  REQUIRE(whole > 5);
  std::uint32_t enough = 0;
  std::size_t visits = 0;
  const auto count = [&](const TouchEntry&) { ++visits; };
  while (visits = 0, all.view.for_each_touch(probe, enough, count)) {
    REQUIRE(visits <= enough);
    ++enough;
  }
  CHECK(visits == whole);
}

TEST_CASE("A shape of touch lists that leads outside its cells is called inconsistent",
          "[touch_lists]") {
  const Lists all(records_of(random_scene(SceneKind::kScattered, 3, 300)), 0.01F);
  REQUIRE(all.lists.shape().level_count >= 2);
  const auto refused = [&](auto&& spoil) {
    proto::TouchShape bad = all.lists.shape();
    spoil(bad);
    return !is_consistent(bad);
  };
  CHECK_FALSE(refused([](auto&) {}));
  CHECK(refused([](auto& shape) { shape.level_count = proto::kMaxLevels + 1; }));
  CHECK(refused([](auto& shape) { --shape.cell_count; }));
  CHECK(refused([](auto& shape) { ++shape.levels[1].cells[2]; }));
  CHECK(refused([](auto& shape) { ++shape.levels[1].first_cell; }) ==
        (all.lists.shape().level_count == 2));
  for (const float bad : {0.0F, -0.01F, kNaN, kInfinity})
    CHECK(refused([&](auto& shape) { shape.probe_radius_m = bad; }));
  for (const float bad : {0.0F, -0.01F, kNaN})
    CHECK(refused([&](auto& shape) { shape.levels[0].voxel_m = bad; }));
}

}  // namespace
}  // namespace stillgrid::collision::touch_lists_test

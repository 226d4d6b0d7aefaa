/// Fig. 4 of the paper, redrawn: what a voxel's size costs, for spheres strewn in a volume, in a
/// sheet and along a thread; by the paper's grid, which is counted too, and by ours. Prints CSV;
/// scripts/gallery/measure_detection.py runs it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "sim_server/contact/moving_spheres.hpp"
#include "tests/performance/paper_grid.hpp"

namespace stillgrid::performance {
namespace {

constexpr double kRadius = 0.5, kDiameter = 1.0;  // lengths are in diameters
constexpr std::size_t kCount = 4000;
constexpr int kDraws = 60;

struct Shape {
  const char* name;
  int dimension;
  double edge;  // of the cube that spheres fill, in `dimension` of its directions
};

/// 0.95 others overlap each sphere.
const Shape kShapes[] = {{"volume", 3, std::cbrt(kCount * 4.0 / 3.0 * std::numbers::pi / 0.95)},
                         {"sheet", 2, std::sqrt(kCount* std::numbers::pi / 0.95)},
                         {"thread", 1, kCount * 2.0 / 0.95}};

double thread_ns() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

/// The draws put a sheet or thread at all places between voxels, evenly.
std::vector<collision::SweptBound> strewn(const Shape& shape, double edge, double h, int draw,
                                          std::mt19937& random) {
  std::uniform_real_distribution<double> along(0.0, edge);
  const double place[3] = {0.0, h * (1.0 + (draw * 7 % kDraws + 0.5) / kDraws),
                           h * (1.0 + (draw + 0.5) / kDraws)};
  std::vector<collision::SweptBound> balls(kCount);
  for (collision::SweptBound& ball : balls) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      ball.centre_m[axis] = static_cast<float>(
          static_cast<int>(axis) < shape.dimension ? along(random) : place[axis]);
    ball.bounding_radius_m = static_cast<float>(kRadius);
  }
  return balls;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Counts, and what docs/cases.md, case 2.8, has for spheres in a space that repeats.
void measure_paper(const Shape& shape, double ratio) {
  const double h = ratio * kDiameter;
  const auto along = static_cast<std::uint32_t>(std::lround(shape.edge / h));
  const double edge = along * h;  // whole voxels, so that it repeats
  const auto cells = [&](int axis) { return axis < shape.dimension ? along : 16U; };
  PaperGrid<std::uint64_t> grid(static_cast<float>(h), {cells(0), cells(1), cells(2)});
  std::mt19937 random(1);
  std::vector<contact::SpherePair> pairs;
  std::vector<double> ns;
  double entries = 0, visits = 0, tests = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<collision::SweptBound> balls = strewn(shape, edge, h, draw, random);
    const double start_ns = thread_ns();
    const PaperCounts counts = grid.find(balls, pairs);
    ns.push_back((thread_ns() - start_ns) / kCount);
    entries += static_cast<double>(counts.entries) / kDraws / kCount;
    visits += static_cast<double>(counts.visits) / kDraws / kCount;
    tests += static_cast<double>(counts.tests) / kDraws / kCount;
  }
  const int d = shape.dimension;
  const double others = 0.5 * (kCount - 1), layers = 1.0 + 1.0 / ratio;
  std::printf(
      "%s,paper,%.4f,%.3f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n", shape.name, ratio, median(ns), entries,
      visits, tests, std::pow(layers, 3),
      others * std::pow(h + kDiameter, 2 * d) / std::pow(h * edge, d) * std::pow(layers, 3 - d),
      others * std::pow((2.0 * kDiameter + h) / edge, d));
}

/// Full searches of spheres that are anywhere at each step, all ratios in turn at each; the last,
/// 0, is as it chooses.
void measure_ours(const Shape& shape, std::span<const double> ratios) {
  struct Choice {
    contact::MovingSpheres spheres;
    std::vector<double> ns;
  };
  std::vector<Choice> choices;
  for (const double ratio : ratios)  // just above 1 it need not look farther than the next voxel
    choices.push_back({{kCount, ratio == 1.0 ? 1.01F : static_cast<float>(ratio)}, {}});
  choices.push_back({{kCount, 0.0F}, {}});
  std::mt19937 random(1);
  for (int draw = 0; draw < kDraws; ++draw) {
    const std::vector<collision::SweptBound> balls = strewn(shape, shape.edge, 1.0, draw, random);
    for (Choice& choice : choices) {
      const double start_ns = thread_ns();
      (void)choice.spheres.find(balls);
      choice.ns.push_back((thread_ns() - start_ns) / kCount);
    }
  }
  for (Choice& choice : choices)
    std::printf("%s,%s,%.4f,%.3f,,,,,,\n", shape.name,
                &choice == &choices.back() ? "ours automatic" : "ours",
                double{choice.spheres.grid().view().shape.levels[0].voxel_m} / kDiameter,
                median(choice.ns));
}

int program_main() {
  std::printf(
      "shape,engine,ratio,ns,entries,visits,tests,"
      "expected_entries,expected_visits,expected_tests\n");
  const double ratios[] = {0.4, 0.5,  0.6, 0.75, 0.9, 1.0, 1.15, 1.33,
                           1.5, 1.75, 2.0, 2.5,  3.0, 4.0, 5.0};
  for (const Shape& shape : kShapes) {
    for (const double ratio : ratios) measure_paper(shape, ratio);
    measure_ours(shape, ratios);
  }
  return 0;
}

}  // namespace
}  // namespace stillgrid::performance

int main() {
  return stillgrid::performance::program_main();
}

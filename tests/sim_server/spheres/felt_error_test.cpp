#include "sim_server/spheres/felt_error.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/sim_server/spheres/generated_solids.hpp"

namespace stillgrid::spheres::felt_error_test {

TEST_CASE("The exact force leads out of the solid, as long as the tool is deep", "[felt_error]") {
  const mesh::TriangleMesh box = mesh::box_mesh({-1, -1, -1}, {1, 1, 1});
  const mesh::MeshDistance distance(box);
  const auto force = [&](double x, double y, double z) {
    return exact_force_m(distance, {x, y, z}, 0.2);
  };
  CHECK(force(1.15, 0.3, 0.1).isApprox(Eigen::Vector3d(0.05, 0, 0)));
  CHECK(force(0.9, 0.3, 0.1).isApprox(Eigen::Vector3d(0.3, 0, 0)));  // its centre is inside
  CHECK(force(1.0, 0.3, 0.1).isApprox(Eigen::Vector3d(0.2, 0, 0)));  // on the surface
  CHECK(force(1.1, 1.1, 0.0).normalized().isApprox(Eigen::Vector3d(1, 1, 0).normalized()));
  CHECK(force(1.21, 0.0, 0.0) == Eigen::Vector3d::Zero());
}

TEST_CASE("A model that errs by a share has that error", "[felt_error]") {
  const mesh::TriangleMesh box = random_box(4);
  const mesh::MeshDistance distance(box);
  const ExactForces places = press_everywhere(box, distance, 500, 0.05, std::array{0.01, 0.02});
  REQUIRE(places.tool_m.size() > 300);
  const auto error = [&](double factor) {
    return unscaled_error(places,
                          [&](const Eigen::Vector3d& tool_m) -> Eigen::Vector3d {
                            return factor * exact_force_m(distance, tool_m, 0.05);
                          })
        .share;
  };
  CHECK(error(1.0) < 1e-12);
  CHECK(error(1.07) == Approx(0.07));
  CHECK(error(0.5) == Approx(0.5));
}

TEST_CASE("The error of a force is that of its size and of its direction, of the best stiffness",
          "[felt_error]") {
  std::mt19937 random(GENERATE(1U, 2U, 3U));
  std::normal_distribution<double> any;
  ExactForces exact;
  for (int i = 0; i < 200; ++i) {
    exact.tool_m.emplace_back(i, 0.0, 0.0);
    exact.force_m.push_back(Eigen::Vector3d(any(random), any(random), any(random)));
  }
  const auto of = [&](const Eigen::Vector3d& at_m) -> const Eigen::Vector3d& {
    return exact.force_m[static_cast<std::size_t>(at_m.x())];
  };
  CHECK(felt_error(exact, [&](const Eigen::Vector3d& at_m) { return 7.3 * of(at_m); }).share <
        1e-7);
  // All turned alike by an angle: what stays across is its sine.
  const double angle = 0.31;
  const auto turned = [&](const Eigen::Vector3d& at_m) -> Eigen::Vector3d {
    const Eigen::Vector3d across = of(at_m).unitOrthogonal();
    return std::cos(angle) * of(at_m) + std::sin(angle) * of(at_m).norm() * across;
  };
  CHECK(felt_error(exact, turned).share == Approx(std::sin(angle)).epsilon(1e-9));
  CHECK(felt_error(exact, turned).stiffness_scale == Approx(std::cos(angle)).epsilon(1e-9));
  // No other stiffness is better.
  const auto any_force = [&](const Eigen::Vector3d& at_m) -> Eigen::Vector3d {
    return of(at_m) + Eigen::Vector3d(0.4, std::sin(at_m.x()), -0.2);
  };
  const FeltError best = felt_error(exact, any_force);
  for (const double factor : {0.9, 0.99, 1.0, 1.01, 1.1}) {
    double error_m2 = 0.0, true_m2 = 0.0;
    for (std::size_t i = 0; i < exact.tool_m.size(); ++i) {
      error_m2 += (factor * best.stiffness_scale * any_force(exact.tool_m[i]) - exact.force_m[i])
                      .squaredNorm();
      true_m2 += exact.force_m[i].squaredNorm();
    }
    if (factor == 1.0)
      CHECK(best.share == Approx(std::sqrt(error_m2 / true_m2)).epsilon(1e-9));
    else
      CHECK(best.share < std::sqrt(error_m2 / true_m2));
  }
  CHECK(felt_error(exact, [](const Eigen::Vector3d&) {
          return Eigen::Vector3d::Zero().eval();
        }).share == 1.0);
}

TEST_CASE("A share of a force is read as scene_fit reads it", "[felt_error]") {
  CHECK(read_force_share("5%").value() == Approx(0.05));
  CHECK(read_force_share("0.05").value() == Approx(0.05));
  CHECK(read_force_share("0.7jnd").value() == Approx(0.049));
  CHECK(read_force_share("0.7JND").value() == Approx(0.049));
  CHECK(read_force_share("900%").value() == Approx(9.0));
  for (const char* const none : {"", "%", "jnd", "5", "1", "0", "-3%", "nan", "nan%", "inf jnd",
                                 "0.7 jnd", "1e3%", "5%%", "0.7jndx", "x0.5", "0.5x"}) {
    CAPTURE(none);
    CHECK_FALSE(read_force_share(none).has_value());
  }
  // Where a caller has limits of its own.
  CHECK(read_force_share("5", kAnyShare).value() == Approx(5.0));
  CHECK(read_force_share("90000%", kAnyShare).value() == Approx(900.0));
  CHECK_FALSE(read_force_share("inf", kAnyShare).has_value());
}

}  // namespace stillgrid::spheres::felt_error_test

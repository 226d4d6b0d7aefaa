#include "shared/collision/contact_law.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace stillgrid::collision::contact_law_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

ContactMaterial spring_only(double stiffness_N_per_m) {
  return {.stiffness_N_per_m = stiffness_N_per_m, .damping_N_s_per_m = 0.0, .friction = 0.0};
}

/// The force on a probe that presses a row of spheres along x.
struct Row {
  double bounding_radius_m = 0.015;  // sum of the probe's radius and a sphere's
  double depth_m = 0.002;            // under the row's top
  double spacing_m;

  [[nodiscard]] double height_m() const { return bounding_radius_m - depth_m; }

  [[nodiscard]] Eigen::Vector3d force_N(double along_m) const {
    Eigen::Vector3d sum_N = Eigen::Vector3d::Zero();
    const Eigen::Vector3d probe_m(along_m, height_m(), 0.0);
    for (int i = -5; i <= 5; ++i) {
      const Eigen::Vector3d apart_m = probe_m - Eigen::Vector3d(i * spacing_m, 0.0, 0.0);
      const double distance_m = apart_m.norm();
      sum_N += contact_force_N(spring_only(500.0), bounding_radius_m - distance_m,
                               apart_m / distance_m, Eigen::Vector3d::Zero());
    }
    return sum_N;
  }
};

struct RowFigures {
  double spacing_m, at_centre_N, between_N, least_to_most, mean_N;
};

TEST_CASE("A row of spheres pushes a probe with the known forces", "[contact_law]") {
  const auto known = GENERATE(RowFigures{0.010, 1.00000, 1.00018, 0.87923, 0.95426},
                              RowFigures{0.0125, 1.00000, 0.51879, 0.51879, 0.76341},
                              RowFigures{0.005, 2.00018, 1.73010, 0.86496, 1.90852});
  const Row row{.spacing_m = known.spacing_m};
  CAPTURE(known.spacing_m);

  CHECK(row.force_N(0.0).y() == Approx(known.at_centre_N).margin(1e-4));
  CHECK(row.force_N(known.spacing_m / 2.0).y() == Approx(known.between_N).margin(1e-4));
  CHECK(std::abs(row.force_N(known.spacing_m / 2.0).x()) < 1e-12);

  constexpr int kSamples = 20000;
  double least_N = INFINITY, most_N = 0.0, sum_N = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector3d force_N = row.force_N(known.spacing_m * i / kSamples);
    least_N = std::min(least_N, force_N.norm());
    most_N = std::max(most_N, force_N.norm());
    sum_N += force_N.y();
  }
  CHECK(least_N / most_N == Approx(known.least_to_most).margin(1e-4));
  CHECK(sum_N / kSamples == Approx(known.mean_N).margin(1e-4));
  const double chord_m = std::sqrt(0.015 * 0.015 - 0.013 * 0.013);
  const double exact_mean_N =
      500.0 * 0.013 / known.spacing_m * (2.0 * 0.015 * std::asinh(chord_m / 0.013) - 2.0 * chord_m);
  CHECK(sum_N / kSamples == Approx(exact_mean_N).epsilon(1e-4));
}

TEST_CASE("A row opens a hole where its spheres stand 14.967 mm apart", "[contact_law]") {
  const auto between_N = [](double spacing_m) {
    return Row{.spacing_m = spacing_m}.force_N(spacing_m / 2.0).norm();
  };

  CHECK(2.0 * std::sqrt(0.015 * 0.015 - 0.013 * 0.013) == Approx(0.014967).margin(1e-6));
  CHECK(between_N(0.014966) > 0.0);
  CHECK(between_N(0.014967) == 0.0);
}

TEST_CASE("A sphere pushes a probe that is off its axis further off", "[contact_law]") {
  const Row row{.spacing_m = 1.0};  // neighbours out of radius
  constexpr double kStep_m = 1e-7;

  CHECK(row.force_N(kStep_m).x() / kStep_m == Approx(76.92).margin(0.01));  // force / distance
}

TEST_CASE("Between two materials springs and dampers act in series", "[contact_law]") {
  const ContactMaterial soft{500.0, 1.0, 0.2, 1e-3};
  const ContactMaterial hard{2000.0, 4.0, 0.6, 2e-3};
  const ContactMaterial pair = pair_material(soft, hard);

  CHECK(pair.stiffness_N_per_m == Approx(800.0));
  CHECK(pair.damping_N_s_per_m == Approx(1.6));
  CHECK(pair.friction == 0.2);
  CHECK(pair.slip_speed_m_s == 2e-3);

  const ContactMaterial alike = pair_material(soft, soft);
  CHECK(alike.stiffness_N_per_m == Approx(500.0));
  CHECK(alike.damping_N_s_per_m == Approx(1.0));

  const ContactMaterial none = pair_material(spring_only(0.0), spring_only(0.0));
  CHECK(none.stiffness_N_per_m == 0.0);
}

TEST_CASE("Without overlap there is no force", "[contact_law]") {
  const ContactMaterial material{500.0, 10.0, 0.5, 1e-3};
  const Eigen::Vector3d fast_m_s(1.0, -10.0, 2.0);
  const double depth_m = GENERATE(0.0, -1e-9, -1.0, -INFINITY, std::nan(""));

  CHECK(normal_force_N(material, depth_m, 10.0) == 0.0);
  CHECK(contact_force_N(material, depth_m, Eigen::Vector3d::UnitY(), fast_m_s).isZero(0.0));
}

TEST_CASE("The damper acts only while two bodies approach", "[contact_law]") {
  const ContactMaterial material{500.0, 10.0, 0.0, 1e-3};
  const auto force_N = [&](double separation_m_s) {
    return contact_force_N(material, 0.002, Eigen::Vector3d::UnitY(), {0.0, separation_m_s, 0.0});
  };

  CHECK(force_N(0.0).y() == Approx(1.0));
  CHECK(force_N(-0.05).y() == Approx(1.5));
  CHECK(force_N(0.05).y() == Approx(1.0));
  CHECK(force_N(100.0).y() == Approx(1.0));  // it never pulls
}

TEST_CASE("A damped impact returns the known share of its speed", "[contact_law]") {
  const double damping_ratio = GENERATE(0.0, 0.2, 0.5);
  const double known_share = damping_ratio == 0.2 ? 0.756135 : damping_ratio == 0.5 ? 0.546293 : 1.;
  constexpr double kMass_kg = 0.1, kStiffness_N_per_m = 1000.0, kStep_s = 1e-6;
  const ContactMaterial material{kStiffness_N_per_m,
                                 2.0 * damping_ratio * std::sqrt(kStiffness_N_per_m * kMass_kg),
                                 0.0, 1e-3};

  double depth_m = 0.0, speed_m_s = 1.0;  // into the other body
  do {
    depth_m += 0.5 * kStep_s * speed_m_s;
    speed_m_s -= kStep_s * normal_force_N(material, depth_m, speed_m_s) / kMass_kg;
    depth_m += 0.5 * kStep_s * speed_m_s;
  } while (depth_m > 0.0);

  CHECK(-speed_m_s == Approx(known_share).margin(1e-4));
}

TEST_CASE("Friction opposes the slip and never exceeds Coulomb's limit", "[contact_law]") {
  const ContactMaterial material{500.0, 0.0, 0.3, 1e-3};
  constexpr double kNormalLoad_N = 2.0;
  const Eigen::Vector3d direction = Eigen::Vector3d(0.6, 0.0, -0.8);
  const double speed_m_s = GENERATE(1e-6, 0.25e-3, 0.999e-3, 1e-3, 2e-3, 1.0, 1e3);

  const Eigen::Vector3d force_N = friction_force_N(material, kNormalLoad_N, speed_m_s * direction);

  CHECK(force_N.normalized().isApprox(-direction, 1e-12));
  CHECK(force_N.norm() == Approx(0.6 * std::min(1.0, speed_m_s / 1e-3)));
}

TEST_CASE("A body at rest on another feels no friction", "[contact_law]") {
  const ContactMaterial material{500.0, 0.0, 0.3, 1e-3};
  CHECK(friction_force_N(material, 2.0, Eigen::Vector3d::Zero()).isZero(0.0));
}

TEST_CASE("The contact force is its pressure along the normal and its friction across it",
          "[contact_law]") {
  const ContactMaterial material{500.0, 10.0, 0.3, 1e-3};
  const Eigen::Vector3d normal(0.0, 0.6, 0.8);
  const Eigen::Vector3d slip_m_s(0.02, 0.0, 0.0);

  const Eigen::Vector3d force_N =
      contact_force_N(material, 0.002, normal, slip_m_s - 0.05 * normal);

  CHECK(force_N.isApprox(1.5 * normal - Eigen::Vector3d(0.3 * 1.5, 0.0, 0.0), 1e-12));
}

TEST_CASE("On an incline below the angle of friction a block only creeps", "[contact_law]") {
  const ContactMaterial material{500.0, 0.0, 0.3, 1e-3};
  constexpr double kGravity_m_s2 = 9.81;
  const double slope = 10.0 * kPi / 180.0;
  const double creep_m_s = 0.58776e-3;  // slip speed * tan(slope) / friction

  const Eigen::Vector3d friction_N = friction_force_N(material, kGravity_m_s2 * std::cos(slope),
                                                      creep_m_s * Eigen::Vector3d::UnitX());

  CHECK(friction_N.x() == Approx(-kGravity_m_s2 * std::sin(slope)).epsilon(1e-5));

  const double steep = 30.0 * kPi / 180.0;
  const Eigen::Vector3d sliding_N =
      friction_force_N(material, kGravity_m_s2 * std::cos(steep), 0.5 * Eigen::Vector3d::UnitX());
  CHECK(kGravity_m_s2 * std::sin(steep) + sliding_N.x() == Approx(2.35629).margin(1e-5));
}

}  // namespace
}  // namespace stillgrid::collision::contact_law_test

#pragma once

#include <random>
#include <span>
#include <string>
#include <vector>

#include "sim_server/contact/pair_search.hpp"

namespace stillgrid::contact {

/// Where spheres are, of which a search for pairs must not care.
enum class Cloud {
  kEqual,       // one radius, strewn evenly
  kTwoDecades,  // radii from 1 to 100
  kOnBorders,   // centres and faces on a lattice of one diameter
  kCoincident,  // many at one centre
  kFarAway,     // 1e6 m from the origin, on its negative side
  kWide,        // so far apart that a grid must repeat
  kSheet,
  kThread,
  kCount
};

/// And how they move from step to step.
enum class Drift {
  kNone,
  kSlow,       // straight on, a twentieth of a radius a step, turned back now and then
  kFast,       // straight on, two radii a step
  kTrembling,  // to and fro about a place
  kMixed,      // most rest, some are fast
  kTeleport,   // a few are anywhere at each step
  kCount
};

/// Spheres that a seed decides, and their next steps.
class DriftingCloud {
 public:
  DriftingCloud(Cloud cloud, Drift drift, std::size_t count, std::uint64_t seed);

  void step();
  [[nodiscard]] std::span<const collision::SweptBound> balls() const noexcept { return balls_; }
  [[nodiscard]] std::string description() const;

 private:
  [[nodiscard]] std::array<float, 3> anywhere();

  Cloud cloud_;
  Drift drift_;
  std::uint64_t seed_;
  std::mt19937_64 random_;
  float edge_m_ = 0.0F;
  std::array<float, 3> origin_m_{};
  std::vector<collision::SweptBound> balls_, home_;
  std::vector<std::array<float, 3>> moves_m_;
};

/// All pairs of balls that overlap, ascending: every pair tested, or, where that is too many, every
/// pair whose extents along x meet.
[[nodiscard]] std::vector<SpherePair> tested_pairs(std::span<const collision::SweptBound> balls);

/// The same pairs, ascending.
[[nodiscard]] std::vector<SpherePair> ascending(std::span<const SpherePair> pairs);

}  // namespace stillgrid::contact

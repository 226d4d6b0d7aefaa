#include "sim_server/contact/moving_spheres.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "shared/collision/grid_query.hpp"

namespace stillgrid {
namespace {

/// Entering a sphere and finding its pairs costs as much as so many tests of a listed pair.
constexpr float kEntryOverTest = 25.0F;
/// Steps that covers are made for, at most.
constexpr int kLongestLife = 64;
/// Least room of a cover that is to last, of its radius: what trembles does not leave.
constexpr float kLeastRoom = 0.02F;
/// Beyond the expected error of its prediction.
constexpr float kErrorRoom = 1.5F;
/// The error that is assumed after the first step of a motion, of its length.
constexpr float kFirstError = 0.1F;
/// Pairs a sphere that are reckoned with at least.
constexpr float kFewPairs = 0.05F;
/// Spheres that the motion is measured on, about.
constexpr std::size_t kSamples = 256;
/// A cover that was left is widened by this part of the radius more than need be, and up to so many
/// radii at all.
constexpr float kWiden = 0.25F, kWidest = 4.0F;
/// Other spheres in a sphere's own voxel, of the voxel that is chosen: three voxels in a row then
/// make a vector that is full enough, seldom too long.
constexpr float kCompany = 0.8F;
/// Edges of voxels over twice the covers' reach that may be chosen. Just above 1 the neighbours of
/// a voxel are those that touch it, whatever is rounded.
constexpr float kLeastRatio = 1.01F, kMostRatio = 4.0F;
/// A ratio that is within this part of the wished one is kept.
constexpr float kNearRatio = 0.15F;
constexpr int kFirstTries = 8;
/// Of all spheres, how many may leave their covers at once, or at least.
constexpr std::size_t kLeaversPart = 64, kLeastLeavers = 4;

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

/// Other spheres in the voxel of a sphere, on average; from some of the cells.
float company(const GridView& view) {
  const auto* starts = reinterpret_cast<const std::uint32_t*>(view.words + view.layout.cell_starts);
  const proto::GridLevel& last = view.shape.levels[view.shape.level_count - 1];
  const std::size_t cells =
      last.first_cell + std::size_t{last.cells[0]} * last.cells[1] * last.cells[2];
  const std::size_t stride = cells / (4 * kSamples) + 1;
  float spheres = 0.0F, squares = 0.0F;
  for (std::size_t cell = 0; cell < cells; cell += stride) {
    const auto count = static_cast<float>(starts[cell + 1] - starts[cell]);
    spheres += count;
    squares += count * count;
  }
  return squares / std::max(spheres, 1.0F) - 1.0F;
}

/// What a cover round `centre_m` must reach to hold a ball, whatever is rounded.
float needed_reach_m(const std::array<float, 3>& centre_m, const std::array<float, 3>& position_m,
                     float radius_m) {
  return ((vector(position_m) - vector(centre_m)).norm() + radius_m) * (1.0F + kCoverSlack);
}

}  // namespace

MovingSpheres::MovingSpheres(std::size_t count, float voxel_ratio,
                             std::vector<std::uint32_t> groups)
    : grid_(sizeof(proto::SnapshotHeader), count),
      chooses_voxel_(!(voxel_ratio > 0.0F)),
      voxel_ratio_(chooses_voxel_ ? kLeastRatio : voxel_ratio),
      covers_(count),
      entered_(count),
      grown_(count),
      moves_m_(count, Eigen::Vector3f::Zero()),
      groups_(std::move(groups)),
      sorted_(count),
      leavers_(std::max(kLeastLeavers, count / kLeaversPart)) {
  assert(groups_.empty() || groups_.size() == count);
}

std::optional<std::span<const SpherePair>> MovingSpheres::find_at_most(
    std::span<const Cover> balls, const PairFilter& may_collide, std::size_t most) {
  assert(balls.size() == covers_.size());
  ++steps_;
  if (!is_listed_ || !list_holds(balls, may_collide)) {
    enter(balls);
    if (!list_pairs(may_collide, most)) {
      if (life_ == 1) return std::nullopt;
      // Covers that are to last gather more than those of this step alone.
      life_ = 1;
      make_covers(balls);
      fill_grid();
      if (!list_pairs(may_collide, most)) return std::nullopt;
    }
  }
  found_ = overlapping_pairs({candidates_.data(), listed_}, balls, pairs_);
  return std::span<const SpherePair>(pairs_.data(), found_);
}

/// Whether the list of pairs is good for these balls, if need be after a few covers are widened.
bool MovingSpheres::list_holds(std::span<const Cover> balls, const PairFilter& may_collide) {
  const std::size_t leaving = find_leavers(balls, covers_, leavers_);
  if (leaving > leavers_.size()) return false;
  for (std::size_t i = 0; i < leaving; ++i)
    if (!widen(leavers_[i], balls[leavers_[i]], may_collide)) return false;
  return true;
}

/// Widens one cover in place and lists the pairs that come to meet by it. False if it would be too
/// wide, or no number.
bool MovingSpheres::widen(std::uint32_t sphere, const Cover& ball, const PairFilter& may_collide) {
  const Cover before = covers_[sphere];
  Cover now = before;
  now.reach_m =
      needed_reach_m(before.centre_m, ball.centre_m, ball.reach_m) + kWiden * ball.reach_m;
  if (!(now.reach_m <= kWidest * ball.reach_m)) return false;
  grid_.grow(sphere, now.reach_m);
  covers_[sphere] = now;
  for_each_candidate(grid_.view(), now, kAllVisits, [&](std::uint32_t other) {
    if (other == sphere || !meet(now, covers_[other]) || meet(before, covers_[other])) return;
    const SpherePair pair{std::min(sphere, other), std::max(sphere, other)};
    if (may_collide && !may_collide(pair.a, pair.b)) return;
    if (listed_ == candidates_.size()) candidates_.resize(2 * listed_ + 64);
    candidates_[listed_++] = pair;
  });
  if (pairs_.size() < listed_) pairs_.resize(2 * listed_);
  return listed_ <= 2 * listed_when_entered_ + covers_.size() / 4;
}

void MovingSpheres::enter(std::span<const Cover> balls) {
  is_listed_ = false;  // should it throw
  plan(balls);
  make_covers(balls);
  fill_grid();
  std::copy(balls.begin(), balls.end(), entered_.begin());
  steps_ = 0;
  ++entered_count_;
}

/// Measures how the spheres moved since they were entered, and decides how long the next covers
/// shall last: wider ones list more pairs, which every step tests, and are made anew less often.
void MovingSpheres::plan(std::span<const Cover> balls) {
  if (entered_count_ == 0) {
    life_ = kLongestLife;  // as if nothing moved
    return;
  }
  const float per_step = 1.0F / static_cast<float>(std::max(1, steps_));
  const auto measure = [&](std::size_t i) {
    return per_step * (vector(balls[i].centre_m) - vector(entered_[i].centre_m));
  };
  const std::size_t stride = std::max<std::size_t>(1, balls.size() / kSamples);
  float repeated_m2 = 0.0F, before_m2 = 0.0F, move_m = 0.0F, error_m = 0.0F, radius_m = 0.0F;
  for (std::size_t i = 0; i < balls.size(); i += stride) {
    const Eigen::Vector3f now_m = measure(i), before_m = moves_m_[i];
    repeated_m2 += now_m.dot(before_m);
    before_m2 += before_m.squaredNorm();
    move_m += now_m.norm();
    radius_m += balls[i].reach_m;
  }
  lead_ = before_m2 > 0.0F ? std::clamp(repeated_m2 / before_m2, 0.0F, 1.0F) : 1.0F;
  for (std::size_t i = 0; i < balls.size(); i += stride)
    error_m += (measure(i) - lead_ * moves_m_[i]).norm();
  if (before_m2 == 0.0F) error_m = kFirstError * move_m;  // nothing to tell it from yet
  for (std::size_t i = 0; i < balls.size(); ++i) moves_m_[i] = measure(i);

  const float samples = std::ceil(static_cast<float>(balls.size()) / static_cast<float>(stride));
  error_m_ = error_m / samples;
  const float wider = (0.5F * lead_ * move_m + kErrorRoom * error_m) / radius_m;  // a step
  const float pairs =
      std::max(kFewPairs, static_cast<float>(found_) / static_cast<float>(balls.size()));
  const auto cost = [&](int life) {  // of a step and sphere, in tests
    const float wide = life == 1 ? 1.0F : 1.0F + static_cast<float>(life) * wider;
    return kEntryOverTest / static_cast<float>(life) + pairs * wide * wide * wide;
  };
  life_ = 1;
  for (int life = 2; life <= kLongestLife; ++life)
    if (cost(life) < cost(life_)) life_ = life;
}

void MovingSpheres::make_covers(std::span<const Cover> balls) {
  const float life = static_cast<float>(life_);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const auto& [position_m, radius_m] = balls[i];
    Cover& cover = covers_[i];
    cover = balls[i];
    if (life_ == 1) {
      cover.reach_m *= 1.0F + kCoverSlack;
      continue;
    }
    Eigen::Vector3f ahead_m = 0.5F * life * lead_ * moves_m_[i];
    ahead_m *= std::min(1.0F, radius_m / std::max(ahead_m.norm(), radius_m));
    for (std::size_t axis = 0; axis < 3; ++axis)
      cover.centre_m[axis] += ahead_m[static_cast<Eigen::Index>(axis)];
    const float room_m =
        std::min(std::max(kLeastRoom * radius_m, kErrorRoom * life * error_m_), radius_m);
    cover.reach_m = needed_reach_m(cover.centre_m, position_m, radius_m + room_m);
  }
}

/// Enters the covers. A voxel that is chosen follows what the last one held; the first is found by
/// trying.
void MovingSpheres::fill_grid() {
  if (!chooses_voxel_ || covers_.size() < 2) return grid_.enter(covers_, voxel_ratio_);
  float longest_m = 0.0F;
  for (const Cover& cover : covers_) longest_m = std::max(longest_m, cover.reach_m);
  for (int tries = entered_count_ == 0 ? kFirstTries : 1; tries > 0; --tries) {
    voxel_ratio_ = std::clamp(0.5F * voxel_m_ / longest_m, kLeastRatio, kMostRatio);
    grid_.enter(covers_, voxel_ratio_);
    const float wished = std::cbrt(kCompany / std::max(company(grid_.view()), 1e-3F));
    if (std::abs(wished - 1.0F) < kNearRatio) break;
    voxel_m_ = 2.0F * longest_m * voxel_ratio_ * std::clamp(wished, 0.5F, 2.0F);
  }
}

/// False where there are more than `most`.
bool MovingSpheres::list_pairs(const PairFilter& may_collide, std::size_t most) {
  listed_ = search_pairs(grid_.view(), groups_, most, sorted_, candidates_);
  if (listed_ > most) {
    listed_ = 0;
    return false;
  }
  if (may_collide) {
    const auto end = candidates_.begin() + static_cast<std::ptrdiff_t>(listed_);
    const auto kept = std::remove_if(candidates_.begin(), end, [&](const SpherePair& pair) {
      return !may_collide(pair.a, pair.b);
    });
    listed_ = static_cast<std::size_t>(kept - candidates_.begin());
  }
  listed_when_entered_ = listed_;
  if (pairs_.size() < listed_) pairs_.resize(listed_ + listed_ / 4);
  is_listed_ = true;
  return true;
}

void MovingSpheres::reshape() {
  const proto::GridShape shape = grid_.view().shape;
  const auto outgrown = [&](const proto::GridLevel& level) {
    return level.reach_m * voxel_ratio_ > level.voxel_m;  // shaped for half of that
  };
  const auto* const end = shape.levels.data() + shape.level_count;
  if (std::none_of(shape.levels.data(), end, outgrown)) return;
  for (std::size_t i = 0; i < grown_.size(); ++i) grown_[i] = grid_.cover(i);
  grid_.enter(grown_, voxel_ratio_);
}

}  // namespace stillgrid

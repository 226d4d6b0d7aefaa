#include "sim_server/contact/moving_spheres.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "shared/collision/grid_query.hpp"

namespace stillgrid::contact {
namespace {

/// Entering a sphere and finding its pairs costs as much as so many tests of a listed pair.
constexpr float kEntryOverTest = 25.0F;
/// Steps that swept bounds are made for, at most.
constexpr int kMaxRebuildInterval = 64;
/// Least room of a swept bound that is to last, of its radius: what trembles does not leave.
constexpr float kLeastRoom = 0.02F;
/// Beyond the expected error of its prediction.
constexpr float kErrorRoom = 1.5F;
/// The error that is assumed after the first step of a motion, of its length.
constexpr float kFirstError = 0.1F;
/// Pairs a sphere that are reckoned with at least.
constexpr float kFewPairs = 0.05F;
/// Spheres that the motion is measured on, at most.
constexpr std::size_t kSamples = 256;
/// A swept bound that was left is widened by this part of the radius more than need be, and up to
/// so many radii at all.
constexpr float kWiden = 0.25F, kWidest = 4.0F;
/// Other spheres in a sphere's own voxel, of the voxel that is chosen: three voxels in a row then
/// make a vector that is full enough, seldom too long.
constexpr float kOccupancy = 0.8F;
/// Edges of voxels over twice the swept bounds' radius that may be chosen. Just above 1 the
/// neighbours of a voxel are those that touch it, whatever is rounded.
constexpr float kLeastRatio = 1.01F, kMaxRatio = 4.0F;
/// A ratio that is within this part of the wished one is kept.
constexpr float kNearRatio = 0.15F;
constexpr int kFirstTries = 8;
/// Octaves of radius that share a level while it is not crowded, and how crowded it may be: beyond
/// as many other spheres in a sphere's own voxel two levels cost less. So many fillings later that
/// is tried again.
constexpr std::uint32_t kSharedOctaves = 2;
constexpr float kCrowded = 2.5F;
constexpr std::uint64_t kFillingsApart = 64;
/// Of all spheres, how many may leave their swept bounds at once, or at least.
constexpr std::size_t kEscapedPart = 64, kLeastEscaped = 4;

Eigen::Map<const Eigen::Vector3f> vector(const std::array<float, 3>& v) {
  return Eigen::Map<const Eigen::Vector3f>(v.data());
}

/// Other spheres in the voxel of a sphere, on average; from some of the cells.
float occupancy(const collision::GridView& view) {
  const auto* starts = reinterpret_cast<const std::uint32_t*>(view.words + view.layout.cell_starts);
  const proto::GridLevel& last = view.shape.levels[view.shape.level_count - 1];
  const std::size_t cells =
      last.first_cell + std::size_t{last.cells[0]} * last.cells[1] * last.cells[2];
  const std::size_t stride = cells / (4 * kSamples) + 1;
  std::uint64_t spheres = 0, squares = 0;
  for (std::size_t cell = 0; cell < cells; cell += stride) {
    const std::uint64_t count = starts[cell + 1] - starts[cell];
    spheres += count;
    squares += count * count;
  }
  return static_cast<float>(squares) / std::max(static_cast<float>(spheres), 1.0F) - 1.0F;
}

/// How a ball moved in a step, of as many as 1 / per_step.
Eigen::Vector3f move_m(const collision::SweptBound& before, const collision::SweptBound& now,
                       float per_step) {
  return per_step * (vector(now.centre_m) - vector(before.centre_m));
}

/// What a swept bound round `centre_m` must extend to hold a ball, whatever is rounded.
float needed_radius_m(const std::array<float, 3>& centre_m, const std::array<float, 3>& position_m,
                      float radius_m) {
  return ((vector(position_m) - vector(centre_m)).norm() + radius_m) * (1.0F + kBoundSlack);
}

}  // namespace

MovingSpheres::MovingSpheres(std::size_t count, float voxel_ratio,
                             std::vector<std::uint32_t> groups)
    : grid_(sizeof(proto::SnapshotHeader), count),
      chooses_voxel_(!(voxel_ratio > 0.0F)),
      voxel_ratio_(chooses_voxel_ ? kLeastRatio : voxel_ratio),
      swept_bounds_(count),
      entered_(count),
      moves_m_(kSamples, Eigen::Vector3f::Zero()),
      groups_(std::move(groups)),
      sorted_(count),
      escaped_(std::max(kLeastEscaped, count / kEscapedPart)) {
  assert(groups_.empty() || groups_.size() == count);
}

std::optional<std::span<const SpherePair>> MovingSpheres::find_at_most(
    std::span<const collision::SweptBound> balls, const PairFilter& may_collide, std::size_t most) {
  assert(balls.size() == swept_bounds_.size());
  ++steps_;
  if (!is_listed_ || !list_holds(balls, may_collide)) {
    enter(balls);
    if (!list_pairs(may_collide, most)) {
      if (rebuild_interval_ == 1) return std::nullopt;
      // Swept bounds that are to last gather more than those of this step alone.
      rebuild_interval_ = 1;
      make_bounds(balls);
      fill_grid();
      if (!list_pairs(may_collide, most)) return std::nullopt;
    }
  }
  found_ = overlapping_pairs({candidates_.data(), listed_}, balls, pairs_);
  return std::span<const SpherePair>(pairs_.data(), found_);
}

/// Whether the list of pairs is good for these balls, if need be after a few swept bounds are
/// widened.
bool MovingSpheres::list_holds(std::span<const collision::SweptBound> balls,
                               const PairFilter& may_collide) {
  const std::size_t leaving = find_escaped(balls, swept_bounds_, escaped_);
  if (leaving > escaped_.size()) return false;
  for (std::size_t i = 0; i < leaving; ++i)
    if (!widen(escaped_[i], balls[escaped_[i]], may_collide)) return false;
  return true;
}

/// Widens one swept bound in place and lists the pairs that come to meet by it. False if it would
/// be too wide, or no number.
bool MovingSpheres::widen(std::uint32_t sphere, const collision::SweptBound& ball,
                          const PairFilter& may_collide) {
  const collision::SweptBound before = swept_bounds_[sphere];
  collision::SweptBound now = before;
  now.bounding_radius_m = needed_radius_m(before.centre_m, ball.centre_m, ball.bounding_radius_m) +
                          kWiden * ball.bounding_radius_m;
  if (!(now.bounding_radius_m <= kWidest * ball.bounding_radius_m)) return false;
  grid_.grow(sphere, now.bounding_radius_m);
  swept_bounds_[sphere] = now;
  const std::size_t listed = listed_;
  collision::for_each_candidate(grid_.view(), now, collision::kAllVisits, [&](std::uint32_t other) {
    if (other == sphere || !collision::meet(now, swept_bounds_[other]) ||
        collision::meet(before, swept_bounds_[other]))
      return;
    const SpherePair pair{std::min(sphere, other), std::max(sphere, other)};
    if (may_collide && !may_collide(pair.a, pair.b)) return;
    if (listed_ == candidates_.size()) candidates_.resize(2 * listed_ + 64);
    candidates_[listed_++] = pair;
  });
  // Not in the grid's order: what a snapshot needs more of it must not be felt.
  std::sort(
      candidates_.begin() + static_cast<std::ptrdiff_t>(listed),
      candidates_.begin() + static_cast<std::ptrdiff_t>(listed_),
      [](const SpherePair& p, const SpherePair& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
  if (pairs_.size() < listed_) pairs_.resize(2 * listed_);
  return listed_ <= 2 * listed_when_entered_ + swept_bounds_.size() / 4;
}

void MovingSpheres::enter(std::span<const collision::SweptBound> balls) {
  is_listed_ = false;  // should it throw
  plan(balls);
  make_bounds(balls);
  fill_grid();
  std::copy(balls.begin(), balls.end(), entered_.begin());
  steps_ = 0;
  ++entered_count_;
}

/// Measures how the spheres moved since they were entered, and decides how long the next swept
/// bounds shall last: wider ones list more pairs, which every step tests, and are made anew less
/// often.
void MovingSpheres::plan(std::span<const collision::SweptBound> balls) {
  if (entered_count_ == 0) {
    rebuild_interval_ = kMaxRebuildInterval;  // as if nothing moved
    return;
  }
  const std::size_t stride = (balls.size() + kSamples - 1) / kSamples;
  const float per_step = 1.0F / static_cast<float>(std::max(1, steps_));
  std::array<Eigen::Vector3f, kSamples> now_m;
  float repeated_m2 = 0.0F, before_m2 = 0.0F, moved_m = 0.0F, error_m = 0.0F, radius_m = 0.0F;
  std::size_t samples = 0;
  for (std::size_t i = 0; i < balls.size(); i += stride, ++samples) {
    const Eigen::Vector3f& before_m = moves_m_[samples];
    const Eigen::Vector3f sample_m = move_m(entered_[i], balls[i], per_step);
    now_m[samples] = sample_m;
    repeated_m2 += sample_m.dot(before_m);
    before_m2 += before_m.squaredNorm();
    moved_m += sample_m.norm();
    radius_m += balls[i].bounding_radius_m;
  }
  lead_ = before_m2 > 0.0F ? std::clamp(repeated_m2 / before_m2, 0.0F, 1.0F) : 1.0F;
  for (std::size_t k = 0; k < samples; ++k) error_m += (now_m[k] - lead_ * moves_m_[k]).norm();
  std::copy_n(now_m.begin(), samples, moves_m_.begin());
  if (before_m2 == 0.0F) error_m = kFirstError * moved_m;  // nothing to tell it from yet

  error_m_ = error_m / static_cast<float>(samples);
  const float wider = (0.5F * lead_ * moved_m + kErrorRoom * error_m) / radius_m;  // a step
  const float pairs =
      std::max(kFewPairs, static_cast<float>(found_) / static_cast<float>(balls.size()));
  const auto cost = [&](int rebuild_interval) {  // of a step and sphere, in tests
    const float wide =
        rebuild_interval == 1 ? 1.0F : 1.0F + static_cast<float>(rebuild_interval) * wider;
    return kEntryOverTest / static_cast<float>(rebuild_interval) + pairs * wide * wide * wide;
  };
  rebuild_interval_ = 1;
  for (int rebuild_interval = 2; rebuild_interval <= kMaxRebuildInterval; ++rebuild_interval)
    if (cost(rebuild_interval) < cost(rebuild_interval_)) rebuild_interval_ = rebuild_interval;
}

void MovingSpheres::make_bounds(std::span<const collision::SweptBound> balls) {
  const float rebuild_interval = static_cast<float>(rebuild_interval_);
  const float per_step = 1.0F / static_cast<float>(std::max(1, steps_));
  const float ahead = entered_count_ == 0 ? 0.0F : 0.5F * rebuild_interval * lead_;
  float longest_m = 0.0F;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const auto& [position_m, radius_m] = balls[i];
    collision::SweptBound& swept_bound = swept_bounds_[i];
    swept_bound = balls[i];
    if (rebuild_interval_ == 1) {
      swept_bound.bounding_radius_m *= 1.0F + kBoundSlack;
      longest_m = std::max(longest_m, swept_bound.bounding_radius_m);
      continue;
    }
    Eigen::Vector3f ahead_m = ahead * move_m(entered_[i], balls[i], per_step);
    ahead_m *= std::min(1.0F, radius_m / std::max(ahead_m.norm(), radius_m));
    for (std::size_t axis = 0; axis < 3; ++axis)
      swept_bound.centre_m[axis] += ahead_m[static_cast<Eigen::Index>(axis)];
    const float room_m = std::min(
        std::max(kLeastRoom * radius_m, kErrorRoom * rebuild_interval * error_m_), radius_m);
    swept_bound.bounding_radius_m =
        needed_radius_m(swept_bound.centre_m, position_m, radius_m + room_m);
    longest_m = std::max(longest_m, swept_bound.bounding_radius_m);
  }
  longest_m_ = longest_m;
}

/// Enters the swept bounds, in levels of several octaves unless those hold too many.
void MovingSpheres::fill_grid() {
  if (entered_count_ % kFillingsApart == 0) octaves_ = kSharedOctaves;
  if (fill_levels() <= kCrowded || octaves_ == 1) return;
  octaves_ = 1;
  fill_levels();
}

/// Returns how many other spheres are in a sphere's own voxel. A voxel that is chosen follows what
/// the last one held; the first is found by trying.
float MovingSpheres::fill_levels() {
  float held = 0.0F;
  const bool chooses = chooses_voxel_ && swept_bounds_.size() >= 2;
  for (int tries = entered_count_ == 0 ? kFirstTries : 1; tries > 0; --tries) {
    if (chooses) voxel_ratio_ = std::clamp(0.5F * voxel_m_ / longest_m_, kLeastRatio, kMaxRatio);
    grid_.enter(swept_bounds_, voxel_ratio_, octaves_);
    if (swept_bounds_.size() < 2) break;
    held = occupancy(grid_.view());
    const float wished = std::cbrt(kOccupancy / std::max(held, 1e-3F));
    if (!chooses || std::abs(wished - 1.0F) < kNearRatio) break;
    voxel_m_ = 2.0F * longest_m_ * voxel_ratio_ * std::clamp(wished, 0.5F, 2.0F);
  }
  return held;
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

bool MovingSpheres::is_outgrown() const noexcept {
  const proto::GridShape shape = grid_.view().shape;
  return std::any_of(shape.levels.data(), shape.levels.data() + shape.level_count,
                     [&](const proto::GridLevel& level) {  // shaped for half of that
                       return level.bounding_radius_m * voxel_ratio_ > level.voxel_m;
                     });
}

}  // namespace stillgrid::contact

#include <algorithm>
#include <memory>

#include "tests/fuzz/checked_ticks.hpp"
#include "tests/fuzz/hostile_object.hpp"
#include "tests/fuzz/patch.hpp"
#include "tests/fuzz/valid_segment.hpp"

/// The slots of a scene segment whose fixed part is sound: what a tick reads there may be anything,
/// and anything else a tick later.
///
/// Input: for each of at most four ticks flags u8 (1: the other slot is published as the next
/// snapshot id, so that its words are accepted; 2: the rest of the input fills its payload, 4: from
/// the records on), patches, then what CheckedTicks takes.
namespace stillgrid::fuzz {
namespace {

enum Flag : unsigned { kPublished = 1, kRaw = 2, kSoundHeader = 4 };
constexpr int kMaxTicks = 4;

/// Mapped once; each input starts from the same valid words.
class HostileScene {
 public:
  HostileScene() { object_.remove_name(); }

  void restore() { std::copy(valid_.begin(), valid_.end(), object_.bytes().begin()); }

  void spoil(FuzzInput& input) {
    const unsigned flags = input.take<std::uint8_t>();
    auto& latest = *reinterpret_cast<std::uint64_t*>(parts_[0].data());
    if ((flags & kPublished) != 0) ++latest;
    const std::size_t of_slot = parts_.size() / 2;
    const std::span slot = std::span(parts_).subspan(latest % 2 != 0 ? 1 + of_slot : 1, of_slot);
    if ((flags & kPublished) != 0) *reinterpret_cast<std::uint64_t*>(slot[0].data()) = 2 * latest;
    auto& snapshot_id = *reinterpret_cast<std::uint64_t*>(slot[1].data());  // SnapshotHeader's
    if ((flags & kPublished) != 0) snapshot_id = latest;
    apply_patches(parts_, input);
    if ((flags & kRaw) == 0) return;
    const auto raw = std::as_bytes(input.take_rest());
    std::byte* const target = slot[(flags & kSoundHeader) != 0 ? 2 : 1].data();
    const auto room = static_cast<std::size_t>(slot.back().data() + slot.back().size() - target);
    std::copy_n(raw.begin(), std::min(raw.size(), room), target);
    if ((flags & kPublished) != 0) snapshot_id = latest;  // else nothing of it is taken up
  }

  [[nodiscard]] const publication::SceneView& view() const noexcept { return view_; }

 private:
  std::vector<std::byte> valid_ = valid_scene();
  HostileObject object_{proto::SegmentKind::kScene, valid_};
  std::vector<std::span<std::byte>> parts_ = changing_parts(object_.bytes());
  publication::SceneView view_{*publication::SegmentReader::open(
      HostileObject::session(), proto::SegmentKind::kScene, proto::kSceneLayoutHash)};
  std::vector<std::unique_ptr<ForbiddenBytes>> gaps_ = forbid_gaps(view_.reader().bytes(), valid_);
};

}  // namespace
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static HostileScene scene;
  FuzzInput input({data, size});
  scene.restore();
  const auto checked = std::make_unique<CheckedTicks>();
  for (int i = 0; i < kMaxTicks && (i == 0 || !input.is_empty()); ++i) {
    scene.spoil(input);
    checked->tick(scene.view(), input);
  }
  return 0;
}

}  // namespace stillgrid::fuzz

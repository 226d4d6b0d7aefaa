#include <cmath>
#include <memory>
#include <string_view>

#include "shared/publication/relay_figures.hpp"
#include "shared/publication/tool_segment.hpp"
#include "tests/fuzz/checked_ticks.hpp"
#include "tests/fuzz/hostile_object.hpp"
#include "tests/fuzz/patch.hpp"
#include "tests/fuzz/valid_segment.hpp"

/// The whole of an object that stands under a session's name: its reader takes it up and works with
/// it, or refuses it in one line.
///
/// Input: flags u8 (1: the bytes are the object as they are, from the third on; 2: a tool segment;
/// 4: opened as the other kind; 8: the header declares the size it has; 16: shrunk between two
/// ticks; 32: magic, version, kind and layout are ours), ticks u8. Unless raw: size u16 (0: as it
/// is), patches, then the ticks.
namespace stillgrid::fuzz {
namespace {

enum Flag : unsigned {
  kRaw = 1,
  kTool = 2,
  kOtherKind = 4,
  kOwnSize = 8,
  kShrunk = 16,
  kOurs = 32
};
constexpr std::size_t kMaxTicks = 3, kPageBytes = 4096;

std::vector<std::byte> object_from(FuzzInput& input, unsigned flags) {
  static const std::vector<std::byte> scene = valid_scene(), tool = valid_tool();
  std::vector<std::byte> bytes = (flags & kTool) != 0 ? tool : scene;
  const auto size_bytes = input.take<std::uint16_t>();
  if (size_bytes != 0) bytes.resize(size_bytes);
  const std::span<std::byte> all(bytes);
  const auto part = [&](std::size_t first, std::size_t count) {
    first = std::min(first, all.size());
    return all.subspan(first, std::min(count, all.size() - first));
  };
  const std::vector<std::span<std::byte>> regions{
      part(0, sizeof(proto::SegmentHeader)),
      part(sizeof(proto::SegmentHeader), 256),  // counts and numbers of a scene
      part(sizeof(proto::SegmentHeader), sizeof(proto::SceneHeader)),
      part(sizeof(proto::SegmentHeader) + sizeof(proto::SceneHeader), 4096),  // the static grid
      all};
  apply_patches(regions, input);
  return bytes;
}

/// Past the first checks: what the header says of itself is what a reader asks for.
void pretend(std::span<std::byte> bytes, unsigned flags, proto::SegmentKind kind,
             std::uint64_t layout_hash) {
  if (bytes.size() < sizeof(proto::SegmentHeader)) return;
  proto::SegmentHeader header = header_of(bytes);
  if ((flags & kOwnSize) != 0) header.size_bytes = bytes.size();
  if ((flags & kOurs) != 0) {
    header.magic = proto::kSegmentMagic;
    header.version = proto::kSegmentVersion;
    header.kind = kind;
    header.layout_hash = layout_hash;
  }
  std::memcpy(bytes.data(), &header, sizeof header);
}

/// Of whatever stands in the header only what a relay may have written is shown.
void look_at_relay(const publication::SegmentReader& reader) {
  const auto figures = publication::load_relay_figures(reader.live());
  require(!figures || (figures->relay_id != 0 && publication::is_sound(*figures)),
          "figures of a relay that are shown are sound");
}

void use_scene(publication::SegmentReader&& reader, HostileObject& object, FuzzInput& input,
               unsigned flags, std::size_t ticks) {
  look_at_relay(reader);
  const publication::SceneView scene(std::move(reader));
  const auto checked = std::make_unique<CheckedTicks>();
  for (std::size_t i = 0; i < ticks; ++i) {
    if (i == 1 && (flags & kShrunk) != 0) object.shrink(input.take<std::uint16_t>());
    checked->tick(scene, input);
  }
}

void use_tool(publication::SegmentReader&& reader, HostileObject& object, unsigned flags) {
  look_at_relay(reader);
  const publication::ToolView tool(std::move(reader));
  if ((flags & kShrunk) != 0) object.shrink(0);
  const auto state = tool.read();
  require(!state || std::isfinite(state->position_m[0]), "a tool's place is a number");
  const auto newest = tool.path().newest();
  const auto sample = newest ? tool.path().sample(*newest) : std::nullopt;
  require(!sample || (sample->number == *newest && publication::is_sound(*sample)),
          "a sample of the path that is taken is sound");
}

void use_object(std::span<std::byte> bytes, FuzzInput& input, unsigned flags, std::size_t ticks) {
  const bool is_tool = ((flags & kTool) != 0) != ((flags & kOtherKind) != 0);
  const auto kind = is_tool ? proto::SegmentKind::kTool : proto::SegmentKind::kScene;
  const auto layout_hash = is_tool ? proto::kToolLayoutHash : proto::kSceneLayoutHash;
  pretend(bytes, flags, kind, layout_hash);
  HostileObject object(kind, bytes);
  try {
    auto reader = publication::SegmentReader::open(HostileObject::session(), kind, layout_hash);
    object.remove_name();
    if (!reader) return;
    // Behind an object lie the rest of its last page and, as a rule, its writer's own mapping.
    const std::span<const std::byte> rest_of_page(
        reader->bytes() + bytes.size(), (kPageBytes - bytes.size() % kPageBytes) % kPageBytes);
    const ForbiddenBytes behind(rest_of_page), writers(object.bytes());
    if (is_tool)
      use_tool(std::move(*reader), object, flags);
    else
      use_scene(std::move(*reader), object, input, flags, ticks);
  } catch (const publication::SegmentError& refusal) {
    const std::string_view line = refusal.what();
    require(!line.empty() && line.find('\n') == std::string_view::npos, "a refusal is one line");
  }
}

}  // namespace
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzInput input({data, size});
  const unsigned flags = input.take<std::uint8_t>();
  const std::size_t ticks = input.take<std::uint8_t>() % (kMaxTicks + 1);
  std::vector<std::byte> bytes;
  if ((flags & kRaw) != 0) {
    const auto raw = std::as_bytes(input.take_rest());
    bytes.assign(raw.begin(), raw.end());
  } else {
    bytes = object_from(input, flags);
  }
  use_object(bytes, input, flags, ticks);
  return 0;
}

}  // namespace stillgrid::fuzz

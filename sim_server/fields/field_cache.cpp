#include "sim_server/fields/field_cache.hpp"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "shared/files/whole_file.hpp"
#include "sim_server/fields/mesh_field.hpp"
#include "sim_server/spheres/kept_file.hpp"

namespace stillgrid::fields {
namespace {

/// What stands before a field's words, in this machine's order of bytes, which is the only one that
/// finds it.
struct Head {
  std::uint64_t checksum;  // of all that follows
  proto::FieldShape shape;
};
static_assert(sizeof(Head) == 64);

std::uint64_t checksum_of(const proto::FieldShape& shape, std::span<const std::uint64_t> words) {
  spheres::Hash hash;
  hash.add(&shape, sizeof shape);
  hash.add(words.data(), words.size_bytes());
  return hash.value();
}

std::string name_of(const mesh::TriangleMesh& closed, const collision::FieldFineness& fineness,
                    const MeasuredSurface& measured) {
  constexpr std::string_view kWay = "field";
  spheres::Hash hash;
  hash.add(&kFieldVersion, sizeof kFieldVersion);
  hash.add(kWay.data(), kWay.size());
  hash.add(fineness.cell_m);
  hash.add(fineness.band_m);
  hash.add(fineness.margin_m);
  hash.add(measured.offset_m);
  if (!measured.places.empty()) hash.add(measured.own_N_per_m);
  for (const StiffnessPlace& place : measured.places) {
    hash.add(place.position_m);
    hash.add(place.stiffness_N_per_m);
  }
  hash.add(closed);
  return hash.text() + ".field";
}

}  // namespace

FieldCache::FieldCache(const std::filesystem::path& scene_folder, const mesh::TriangleMesh& closed,
                       const collision::FieldFineness& fineness, const MeasuredSurface& measured)
    : file_(spheres::kept_folder(scene_folder) / name_of(closed, fineness, measured)) {}

std::optional<collision::DistanceField> FieldCache::read() const {
  if (!spheres::may_read_kept(file_)) return std::nullopt;
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file_, error);
  if (error || bytes < sizeof(Head) || bytes - sizeof(Head) > collision::kMaxFieldBytes)
    return std::nullopt;
  std::ifstream in(file_, std::ios::binary);
  Head head{};
  if (!in.read(reinterpret_cast<char*>(&head), sizeof head) ||
      !collision::is_consistent(head.shape) ||
      collision::field_layout(head.shape).total_words * 8 != bytes - sizeof head)
    return std::nullopt;
  std::vector<std::uint64_t> words(collision::field_layout(head.shape).total_words);
  if (!in.read(reinterpret_cast<char*>(words.data()),
               static_cast<std::streamsize>(8 * words.size())) ||
      checksum_of(head.shape, words) != head.checksum)
    return std::nullopt;
  return collision::DistanceField(head.shape, std::move(words));
}

void FieldCache::write(const collision::DistanceField& field) const {
  spheres::prepare_kept(file_);
  const Head head{checksum_of(field.shape(), field.words()), field.shape()};
  files::write_whole(file_, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(&head), sizeof head);
    out.write(reinterpret_cast<const char*>(field.words().data()),
              static_cast<std::streamsize>(field.bytes()));
  });
}

}  // namespace stillgrid::fields

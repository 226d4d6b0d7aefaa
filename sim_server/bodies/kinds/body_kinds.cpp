#include "sim_server/bodies/kinds/body_kinds.hpp"

namespace stillgrid::bodies {
namespace {

Motions only_static(toml::TableReader& /*table*/) {
  return Motions::kStatic;
}
Motions free_or_static(toml::TableReader& /*table*/) {
  return Motions::kFreeOrStatic;
}
Motions any(toml::TableReader& /*table*/) {
  return Motions::kAny;
}
Motions any_unless_soft(toml::TableReader& table) {
  return table.has("spring_stiffness_N_per_m") ? Motions::kFreeOrStatic : Motions::kAny;
}

constexpr BodyKind kBodyKinds[] = {{"sheet", free_or_static, read_sheet},
                                   {"thread", free_or_static, read_thread},
                                   {"soft_block", free_or_static, read_soft_block},
                                   {"rigid_box", any, read_rigid_box},
                                   {"mesh", any_unless_soft, read_mesh},
                                   {"sphere", any, read_sphere},
                                   {"plane", only_static, read_plane},
                                   {"compound", any, read_compound}};

}  // namespace

std::span<const BodyKind> body_kinds() noexcept {
  return kBodyKinds;
}

}  // namespace stillgrid::bodies

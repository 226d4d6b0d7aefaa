#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

namespace stillgrid::files {

/// A name that files and commands of earlier versions used, and today's.
struct OldName {
  std::string_view before, now;
};

/// Keys of scene format 1, in any table.
inline constexpr std::array kOldSceneKeys = {
    OldName{"contact_stiffness_N_m", "contact_stiffness_N_per_m"},
    OldName{"contact_damping_N_s_m", "contact_damping_N_s_per_m"},
    OldName{"spring_stiffness_N_m", "spring_stiffness_N_per_m"},
    OldName{"spring_damping_N_s_m", "spring_damping_N_s_per_m"},
};

/// Columns of recordings.
inline constexpr std::array kOldColumns = {OldName{"generation", "snapshot_id"},
                                           OldName{"tx_Nm", "tx_N_m"}, OldName{"ty_Nm", "ty_N_m"},
                                           OldName{"tz_Nm", "tz_N_m"}};

/// Flags in the column `flags` of recordings.
inline constexpr std::array kOldFlags = {OldName{"cut", "truncated"}};

/// Keys of scenes and frames in saved views of version 1, at any depth; their flags are kOldFlags.
inline constexpr std::array kOldViewKeys = {
    OldName{"generation", "snapshot_id"},
    OldName{"image", "snapshot"},
    OldName{"foresight_ms", "prediction_ms"},
    OldName{"reach_m", "bounding_radius_m"},
    OldName{"drift_s", "prediction_s"},
    OldName{"answer_lag_s", "compliance_lag_s"},
    OldName{"answer_N", "force_change_N"},
    OldName{"stiffness_N_m", "stiffness_N_per_m"},
    OldName{"damping_N_s_m", "damping_N_s_per_m"},
};

/// Options of the device `phantom`.
inline constexpr std::array kOldDeviceOptions = {
    OldName{"damping_N_s_m", "damping_N_s_per_m"},
    OldName{"hand_damping_N_s_m", "hand_damping_N_s_per_m"},
    OldName{"hand_stiffness_N_m", "hand_stiffness_N_per_m"},
};

/// Today's name for one of a table's old ones; any other name as it is.
[[nodiscard]] constexpr std::string_view name_of_today(std::span<const OldName> names,
                                                       std::string_view name) noexcept {
  const auto* const end = names.data() + names.size();
  const auto* const found =
      std::find_if(names.data(), end, [name](const OldName& old) { return old.before == name; });
  return found == end ? name : found->now;
}

}  // namespace stillgrid::files

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "proto/segment_header.hpp"

namespace stillgrid::reading {

/// A relay's figures as every report tells them: docs/formats.md, "Relay". Null without any.
/// Pre: publication::is_sound(*figures).
[[nodiscard]] nlohmann::ordered_json relay_json(const std::optional<proto::RelayFigures>& figures);

}  // namespace stillgrid::reading

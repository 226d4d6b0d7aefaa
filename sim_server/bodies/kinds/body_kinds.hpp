#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim_server/bodies/kinds/body_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid::bodies {

/// How a kind of body may move.
enum class Motions {
  kStatic,        // no mass, no stiffness of its own
  kFreeOrStatic,  // no one direction tells where all nodes of what deforms are
  kAny,
};

/// A kind of body as scene files name it.
struct BodyKind {
  std::string_view name;
  Motions (*motions)(toml::TableReader& table);
  void (*read)(toml::TableReader& table, BodyDescription& body, std::vector<std::string>& notes);
};

/// Every kind, in the order in which a refusal lists them.
[[nodiscard]] std::span<const BodyKind> body_kinds() noexcept;

}  // namespace stillgrid::bodies

#pragma once

#include <string>
#include <vector>

#include "sim_server/scene/scene_description.hpp"
#include "sim_server/toml/toml_reader.hpp"

namespace stillgrid {

/// Reads what a [[body]] of kind `mesh` has besides every other body's keys: its mesh from a file,
/// the spheres that take its place, and for a soft one its lattice. Adds a line to notes.
///
/// A mesh that bounds no solid is refused at `file`. Decomposing may take seconds.
/// Pre: is_soft says whether the body has springs.
void read_mesh(TableReader& table, bool is_soft, BodyDescription& body,
               std::vector<std::string>& notes);

}  // namespace stillgrid

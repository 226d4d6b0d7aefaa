#pragma once

#include <filesystem>

#include "sim_server/dynamics/choice/memory_need.hpp"

namespace stillgrid::sim_server {

/// What this process may still take: the least of nine tenths of the machine's available memory,
/// of what its control groups leave it, and of its own limit of address space; and what is free
/// where segments are kept. Infinite where the system does not tell.
/// root: where /proc, /sys and /dev are, for tests.
[[nodiscard]] dynamics::Memory available_memory(const std::filesystem::path& root = "/");

}  // namespace stillgrid::sim_server

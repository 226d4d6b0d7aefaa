#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/edge_buffer.hpp"

namespace stillgrid::device_check {
namespace {

Outcome check_table(const Subject& subject) {
  const stillgrid_device_api api = negotiate_table(subject, host_of_checks());
  return {Verdict::kPass, "version " + std::to_string(api.abi), {}};
}

Outcome check_versions(const Subject& subject) {
  const auto negotiate = load_driver(subject);
  for (const std::uint32_t version :
       {0U, STILLGRID_DEVICE_ABI + 1, std::numeric_limits<std::uint32_t>::max()}) {
    stillgrid_host_info host = host_of_checks();
    host.abi = version;
    stillgrid_device_api api{};
    api.struct_size = sizeof api;
    const std::int32_t code = call_driver("negotiate()", [&] { return negotiate(&host, &api); });
    if (code != STILLGRID_DEVICE_E_VERSION)
      broken(code_name(code) + " to a host of version " + std::to_string(version) +
             ", expected E_VERSION");
  }
  return {};
}

Outcome check_nulls(const Subject& subject) {
  const auto negotiate = load_driver(subject);
  const stillgrid_host_info host = host_of_checks();
  stillgrid_device_api api{};
  api.struct_size = sizeof api;
  const auto refused = [](const char* what, std::int32_t code) {
    if (code >= 0) broken(std::string(what) + " is answered by " + code_name(code));
  };
  refused("a null host",
          call_driver("negotiate() of a null host", [&] { return negotiate(nullptr, &api); }));
  refused("a null table",
          call_driver("negotiate() of a null table", [&] { return negotiate(&host, nullptr); }));
  return {};
}

/// One negotiation in which neither struct goes on behind its struct_size.
std::int32_t negotiate_at_edge(stillgrid_device_negotiate_fn negotiate, std::size_t host_size,
                               std::size_t table_size) {
  EdgeBuffer<stillgrid_host_info> host_buffer;
  EdgeBuffer<stillgrid_device_api> table_buffer;
  stillgrid_host_info* const host = host_buffer.cut(host_size);
  stillgrid_device_api* const table = table_buffer.cut(table_size);
  const stillgrid_host_info ours = host_of_checks();
  constexpr std::size_t kSize = sizeof ours.struct_size;
  std::memcpy(reinterpret_cast<std::byte*>(host) + kSize,
              reinterpret_cast<const std::byte*>(&ours) + kSize,
              std::min(host_size, sizeof ours) - kSize);
  const std::string step = "negotiate() with a host info of " + std::to_string(host_size) +
                           " and a table of " + std::to_string(table_size) +
                           " bytes, behind which nothing may be touched";
  const std::int32_t code = call_driver(step.c_str(), [&] { return negotiate(host, table); });
  if (table->struct_size != table_size)
    broken("negotiate() changes struct_size of the table from " + std::to_string(table_size) +
           " to " + std::to_string(table->struct_size));
  return code;
}

Outcome check_sizes(const Subject& subject) {
  const auto negotiate = load_driver(subject);
  constexpr std::size_t kHost = sizeof(stillgrid_host_info);
  constexpr std::size_t kTable = sizeof(stillgrid_device_api);
  for (const std::size_t host : {std::size_t{16}, kHost}) {
    for (const std::size_t table : {std::size_t{0}, std::size_t{8}, std::size_t{48}, kTable}) {
      const std::int32_t code = negotiate_at_edge(negotiate, host, table);
      if ((code == STILLGRID_DEVICE_OK) != (host == kHost && table == kTable))
        broken(code_name(code) + " to a host info of " + std::to_string(host) + " and a table of " +
               std::to_string(table) + " bytes");
    }
  }
  return {};
}

constexpr std::array kChecks = {
    Check{"negotiate.table", "hands over every function, under the host's version", "library.loads",
          check_table},
    Check{"negotiate.versions", "answers E_VERSION to a host of another version", "negotiate.table",
          check_versions},
    Check{"negotiate.nulls", "refuses null arguments", "negotiate.table", check_nulls},
    Check{"negotiate.sizes", "refuses structs of another size, and stays inside struct_size",
          "negotiate.table", check_sizes},
};

}  // namespace

std::span<const Check> negotiate_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check

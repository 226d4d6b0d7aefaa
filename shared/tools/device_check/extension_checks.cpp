#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/struct_sizes.hpp"

namespace stillgrid::device_check {
namespace {

const void* extension(const stillgrid_device_api& api, const char* name) {
  return call_driver("get_extension()", [&] { return api.get_extension(name); });
}

Outcome check_unknown(const Subject& subject) {
  const stillgrid_device_api api = negotiate_table(subject, host_of_checks());
  if (api.get_extension == nullptr) return {Verdict::kPass, "it has none", {}};
  const std::string endless(10'000, 'x');
  for (const char* const name : {"no.such.extension/1", "", STILLGRID_HOST_LOG,
                                 "stillgrid.device.identity/999", endless.c_str()})
    if (extension(api, name) != nullptr)
      broken("get_extension() of '" + std::string(name).substr(0, 40) + "' is not null");
  return {};
}

using Identity = stillgrid_device_identity;
constexpr std::array<std::pair<const char*, char (Identity::*)[STILLGRID_IDENTITY_SIZE]>, 3>
    kTexts = {{{"serial", &Identity::serial},
               {"firmware", &Identity::firmware},
               {"driver", &Identity::driver}}};

Outcome check_identity(const Subject& subject) {
  CheckedDevice device(subject);
  const auto* const table = device.api().get_extension == nullptr
                                ? nullptr
                                : static_cast<const stillgrid_device_identity_api*>(
                                      extension(device.api(), STILLGRID_DEVICE_IDENTITY));
  if (table == nullptr) end_check(Verdict::kSkip, "the driver does not offer it");
  if (table->struct_size < sizeof *table || table->identify == nullptr)
    broken("the table leaves identify() out");
  check_struct<Identity>("identify()",
                         [&](Identity* out) { return table->identify(device.handle(), out); });
  Identity identity{};
  identity.struct_size = sizeof identity;
  device.require(
      call_driver("identify()", [&] { return table->identify(device.handle(), &identity); }),
      "identify()");
  std::string told;
  for (const auto& [name, text] : kTexts) {
    const std::size_t length = ::strnlen(identity.*text, STILLGRID_IDENTITY_SIZE);
    if (length == STILLGRID_IDENTITY_SIZE) broken(std::string(name) + " is not zero-terminated");
    if (length > 0)
      told += (told.empty() ? "" : ", ") + std::string(name) + " '" + (identity.*text) + "'";
  }
  if (call_driver("identify() to a null place",
                  [&] { return table->identify(device.handle(), nullptr); }) >= 0)
    broken("identify() to a null place is not refused");
  return {Verdict::kPass, told.empty() ? "it knows nothing of itself" : told, {}};
}

void live_under(const Subject& subject, const stillgrid_host_info& host) {
  CheckedDevice device(subject, host);
  (void)device.describe();
  device.activate();
  read_ticks(device, 10);
  device.deactivate();
}

Outcome check_host(const Subject& subject) {
  stillgrid_host_info host = host_of_checks();
  live_under(subject, host);
  if (log_complaint() != nullptr) broken(log_complaint());
  host.get_extension = [](const char*) -> const void* { return nullptr; };
  live_under(subject, host);
  host.get_extension = nullptr;
  live_under(subject, host);
  return {};
}

constexpr std::array kChecks = {
    Check{"extensions.unknown", "gives null for an extension that it does not know",
          "negotiate.table", check_unknown},
    Check{"extensions.identity", "tells its identity in zero-terminated strings", "life.order",
          check_identity},
    Check{"extensions.host", "lives without the host's log, and never logs in real time",
          "life.again", check_host},
};

}  // namespace

std::span<const Check> extension_checks() {
  return kChecks;
}

}  // namespace stillgrid::device_check

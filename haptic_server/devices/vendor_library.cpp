#include "haptic_server/devices/vendor_library.hpp"

#include <dlfcn.h>

#include <stdexcept>

#include "haptic_server/devices/driver_host.hpp"

namespace stillgrid::devices {

VendorLibrary::VendorLibrary(const std::string& path,
                             std::initializer_list<const char*> usual_names)
    : name_(path) {
  if (!path.empty()) {
    handle_ = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ == nullptr)
      throw std::runtime_error(std::string("library does not load: ") + dlerror());
    return;
  }
  std::string sought;
  for (const char* const name : usual_names) {
    name_ = name;
    handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (handle_ != nullptr) return;
    sought += (sought.empty() ? "" : ", ") + name_;
  }
  throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                    "the vendor's library is not installed (sought " + sought +
                        "): install it, or say where it is by library=PATH");
}

void* VendorLibrary::found(const char* symbol) const noexcept {
  return dlsym(handle_, symbol);
}

void* VendorLibrary::required(const char* symbol) const {
  void* const function = found(symbol);
  if (function == nullptr) {
    throw DriverError(STILLGRID_DEVICE_E_NO_DEVICE,
                      name_ + " has no function " + symbol + ": not the library expected");
  }
  return function;
}

}  // namespace stillgrid::devices

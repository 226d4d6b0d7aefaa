#pragma once

#include <initializer_list>
#include <string>

namespace stillgrid::devices {

/// A vendor's shared library at the user's place. It stays loaded for good: a vendor's threads and
/// handlers at exit are not asked whether it may go.
class VendorLibrary {
 public:
  /// Loads path, or where that is empty the first of the usual names that the loader finds. Throws
  /// one line: what was sought and why it did not load.
  VendorLibrary(const std::string& path, std::initializer_list<const char*> usual_names);

  /// The vendor's function of this name. Throws a line that names what is missing.
  template <class Function>
  void bind(Function*& function, const char* symbol) const {
    function = reinterpret_cast<Function*>(required(symbol));
  }
  /// As bind(), null where the library has none.
  template <class Function>
  void bind_if_there(Function*& function, const char* symbol) const noexcept {
    function = reinterpret_cast<Function*>(found(symbol));
  }

  /// The file or the name that it was loaded by.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  [[nodiscard]] void* found(const char* symbol) const noexcept;
  [[nodiscard]] void* required(const char* symbol) const;

  void* handle_ = nullptr;
  std::string name_;
};

}  // namespace stillgrid::devices

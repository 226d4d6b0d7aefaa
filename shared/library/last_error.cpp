#include "shared/library/last_error.hpp"

#include <cstdarg>
#include <cstdio>
#include <new>
#include <stdexcept>

#include "shared/publication/segment.hpp"

namespace stillgrid::library {
namespace {

thread_local char line[512];

}  // namespace

int fail(int code, const char* format, ...) noexcept {
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return code;
}

int fail_with_current() noexcept {
  try {
    throw;
  } catch (const publication::OtherBuildError& error) {
    return fail(STILLGRID_E_VERSION, "%s", error.what());
  } catch (const publication::SegmentError& error) {
    return fail(STILLGRID_E_SESSION, "%s", error.what());
  } catch (const std::bad_alloc&) {
    return fail(STILLGRID_E_MEMORY, "out of memory");
  } catch (const std::invalid_argument& error) {
    return fail(STILLGRID_E_ARGUMENT, "%s", error.what());
  } catch (const std::exception& error) {
    return fail(STILLGRID_E_FAULT, "%s", error.what());
  } catch (...) {
    return fail(STILLGRID_E_FAULT, "an exception of an unknown kind");
  }
}

}  // namespace stillgrid::library

const char* stillgrid_last_error(void) {
  return stillgrid::library::line;
}

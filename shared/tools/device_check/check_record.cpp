#include "shared/tools/device_check/check_record.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <system_error>

namespace stillgrid::device_check {
namespace {

CheckRecord own_record;
CheckRecord* record = &own_record;

void copy_text(std::string_view from, std::span<char> to) noexcept {
  const std::size_t length = std::min(from.size(), to.size() - 1);
  std::memcpy(to.data(), from.data(), length);
  to[length] = '\0';
}

}  // namespace

CheckRecord& this_record() noexcept {
  return *record;
}

void share_record(int file) {
  void* const memory =
      ::mmap(nullptr, sizeof(CheckRecord), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED)
    throw std::system_error(errno, std::generic_category(), "the record of a check");
  record = static_cast<CheckRecord*>(memory);
}

void note_step(std::string_view step) noexcept {
  copy_text(step, record->step);
}

void settle(const Outcome& outcome) noexcept {
  if (record->is_claimed.exchange(true)) return;
  copy_text(outcome.line, record->line);
  copy_text(outcome.details, record->details);
  record->verdict = outcome.verdict;
}

void end_check(Verdict verdict, const std::string& line) {
  settle({verdict, line, {}});
  throw CheckEnded();
}

}  // namespace stillgrid::device_check

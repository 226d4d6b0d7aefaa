#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "shared/tools/device_check/verdict.hpp"

namespace stillgrid::device_check {

/// What a check leaves behind however its process ends: in memory shared with the parent.
struct CheckRecord {
  std::atomic<bool> is_claimed = false;
  std::atomic<Verdict> verdict = Verdict::kNone;
  std::array<char, 1024> line{};
  std::array<char, 4096> details{};
  std::array<char, 256> step{};     // what was begun last
  std::uint64_t fuzz_sequence = 0;  // the last one begun
};
static_assert(std::atomic<Verdict>::is_always_lock_free);

/// The record of the check that runs in this process: one of its own until share_record().
[[nodiscard]] CheckRecord& this_record() noexcept;

/// From now on this process writes the record in the file, a CheckRecord long. Throws
/// std::system_error if it cannot be mapped.
void share_record(int file);

/// Names what comes next, for the case that it never returns. Realtime: yes.
void note_step(std::string_view step) noexcept;

/// Records how the check ended; the first outcome stays.
void settle(const Outcome& outcome) noexcept;

/// Thrown when a check ends early; its outcome is recorded already.
struct CheckEnded {};

[[noreturn]] void end_check(Verdict verdict, const std::string& line);

/// Ends the check: its rule is broken, and that is how.
[[noreturn]] inline void broken(const std::string& line) {
  end_check(Verdict::kFail, line);
}

}  // namespace stillgrid::device_check

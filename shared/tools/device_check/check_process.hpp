#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/tools/device_check/check.hpp"

namespace stillgrid::device_check {

/// A check that ran in a process of its own.
struct ProcessOutcome : Outcome {
  bool has_hung = false;
  std::uint64_t fuzz_sequence = 0;  // the last one begun
};

/// The option by which this program, run anew, is told the file of its record.
inline constexpr const char* kRecordOption = "--record-file";

/// Runs this program anew with these arguments (argv[0] among them) and kRecordOption, and says how
/// the check in it ended: as it recorded, or by a crash, the end of its process or the time-out.
/// What a check that failed printed last is among the details.
///
/// Throws std::system_error when there is no process to be had.
[[nodiscard]] ProcessOutcome run_in_process(std::vector<std::string> arguments, double timeout_s);

/// The other side: runs a check in this process and records how it ended. Returns whether the
/// process should end as programs do; at once otherwise, without anybody's destructors.
[[nodiscard]] bool run_here(const Check& check, const Subject& subject);

}  // namespace stillgrid::device_check

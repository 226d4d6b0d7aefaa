#pragma once

#include <cstdint>
#include <string>

namespace stillgrid::device_check {

/// What a check found.
enum class Verdict : std::uint32_t {
  kNone,     // it has not ended yet
  kPass,     // the rule is kept
  kWarn,     // kept by the letter; people will be surprised all the same
  kFail,     // the rule is broken
  kSkip,     // not checked, for the reason that the line tells
  kAbsent,   // not checked: the library is there, a device is not
  kRefused,  // not checked: the driver refuses the options that the user gave
};

struct Outcome {
  Verdict verdict = Verdict::kPass;
  std::string line;     // why; may be empty for a pass
  std::string details;  // further lines, as a histogram; may be empty
};

/// PASS, WARN, FAIL or SKIP.
[[nodiscard]] constexpr const char* verdict_name(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::kPass:
      return "PASS";
    case Verdict::kWarn:
      return "WARN";
    case Verdict::kFail:
      return "FAIL";
    default:
      return "SKIP";
  }
}

}  // namespace stillgrid::device_check

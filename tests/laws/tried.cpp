#include "tests/laws/tried.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <limits>
#include <stdexcept>

#include "tests/laws/known.hpp"

namespace stillgrid::laws {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Tried try_here(const LawCase& law_case) {
  Tried tried;
  try {
    tried.finding = law_of(law_case.law).check(law_case);
  } catch (const NoData& error) {
    tried.outcome = Outcome::kNoData;
    tried.finding = {.applies = false, .what = error.what()};
    return tried;
  } catch (const std::exception& error) {  // no list of known violations covers that
    tried.outcome = Outcome::kViolated;
    tried.finding = {.measured = kInfinite, .what = std::string("thrown: ") + error.what()};
    return tried;
  }
  if (!tried.finding.applies)
    tried.outcome = Outcome::kNotSpokenOf;
  else if (!tried.finding.holds())
    tried.outcome = known_violation(law_case, tried.finding) ? Outcome::kKnown : Outcome::kViolated;
  return tried;
}

/// What a child tells of itself: outcome, numbers, and text to the end.
std::string message_of(const Tried& tried) {
  std::array<char, 64> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "%d %.17g %.17g ", static_cast<int>(tried.outcome),
                tried.finding.measured, tried.finding.allowed);
  return numbers.data() + tried.finding.what;
}

Tried tried_of(const std::string& message) {
  Tried tried;
  char* rest = nullptr;
  tried.outcome = static_cast<Outcome>(std::strtol(message.c_str(), &rest, 10));
  tried.finding.measured = std::strtod(rest, &rest);
  tried.finding.allowed = std::strtod(rest, &rest);
  tried.finding.what = rest + 1;
  tried.finding.applies = tried.outcome == Outcome::kHolds || tried.outcome == Outcome::kViolated ||
                          tried.outcome == Outcome::kKnown;
  return tried;
}

#ifdef NDEBUG
constexpr rlim_t kPatience = 1;
#else
constexpr rlim_t kPatience = 10;  // assertions, and sanitizers with them
#endif

void limit_processor_time(const LawCase& law_case) {
  const bool is_long = law_case.law == 10 || law_case.law >= 12;
  const rlim_t seconds = kPatience * (is_long ? 200 : 20);
  const rlimit limit{.rlim_cur = seconds, .rlim_max = seconds + 1};
  (void)::setrlimit(RLIMIT_CPU, &limit);
}

[[noreturn]] void tell(int pipe, const LawCase& law_case) {
  limit_processor_time(law_case);
  const std::string message = message_of(try_here(law_case));
  const bool told =
      ::write(pipe, message.data(), message.size()) == static_cast<ssize_t>(message.size());
  ::_exit(told ? 0 : 1);
}

std::string read_all(int pipe) {
  std::string text;
  std::array<char, 4096> part{};
  while (true) {
    const ssize_t bytes = ::read(pipe, part.data(), part.size());
    if (bytes <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(bytes));
  }
}

/// What a child that told nothing came to.
Tried tried_of_end(int status) {
  Tried tried;
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    tried.outcome = Outcome::kTooLong;
    tried.finding = {.applies = false, .what = "no end within its processor time"};
    return tried;
  }
  tried.outcome = Outcome::kViolated;
  tried.finding = {
      .measured = kInfinite,
      .what = "crashed, " + (WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                                                 : "status " + std::to_string(status))};
  return tried;
}

}  // namespace

Tried try_case(const LawCase& law_case) {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) throw std::runtime_error("pipe: none left");
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork: no process for a case");
  if (child == 0) tell(pipe[1], law_case);
  ::close(pipe[1]);
  const std::string message = read_all(pipe[0]);
  ::close(pipe[0]);
  int status = 0;
  if (::waitpid(child, &status, 0) != child) throw std::runtime_error("waitpid: no child");
  return status == 0 && !message.empty() ? tried_of(message) : tried_of_end(status);
}

std::string line_of(const LawCase& law_case, const Tried& tried) {
  static constexpr std::array<const char*, kOutcomes> kWords = {
      "holds", "violated", "violated as known", "does not apply", "has no data", "took too long"};
  return "law " + std::to_string(law_case.law) + " " +
         kWords[static_cast<std::size_t>(tried.outcome)] + ", seed " +
         std::to_string(law_case.seed) + ": " + short_number(tried.finding.measured) + " " +
         tried.finding.what + "; allowed " + short_number(tried.finding.allowed);
}

}  // namespace stillgrid::laws

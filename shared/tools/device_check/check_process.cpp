#include "shared/tools/device_check/check_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <system_error>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check_record.hpp"

namespace stillgrid::device_check {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {
    if (descriptor < 0) fail("a file descriptor");
  }
  ~File() { ::close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

/// The record as its parent sees it.
class SharedRecord {
 public:
  SharedRecord() : file_(::memfd_create("record", 0)) {
    if (::ftruncate(file_.get(), sizeof(CheckRecord)) != 0) fail("the record of a check");
    memory_ =
        ::mmap(nullptr, sizeof(CheckRecord), PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0);
    if (memory_ == MAP_FAILED) fail("the record of a check");
    new (memory_) CheckRecord;
  }
  ~SharedRecord() { ::munmap(memory_, sizeof(CheckRecord)); }
  SharedRecord(const SharedRecord&) = delete;
  SharedRecord& operator=(const SharedRecord&) = delete;
  [[nodiscard]] int file() const noexcept { return file_.get(); }
  const CheckRecord* operator->() const noexcept {
    return static_cast<const CheckRecord*>(memory_);
  }

 private:
  File file_;
  void* memory_ = nullptr;
};

/// Becomes the program; never returns.
[[noreturn]] void execute(const std::vector<std::string>& arguments, int output) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};  // crashes are what we are here for
  ::setrlimit(RLIMIT_CORE, &no_core);
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  std::vector<char*> pointers;
  for (const std::string& argument : arguments)
    pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  ::execv("/proc/self/exe", pointers.data());
  ::_exit(127);
}

/// Returns the status of waitpid(); the process is killed when its time is over.
int wait_for(pid_t process, double timeout_s, bool& has_hung) {
  // Not by pidfd_open(): the header of glibc 2.36 forgets C++.
  const File handle(static_cast<int>(::syscall(SYS_pidfd_open, process, 0)));
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(timeout_s);
  pollfd ended{handle.get(), POLLIN, 0};
  int found = 0;
  while (found <= 0) {
    const std::uint64_t now_ns = realtime::monotonic_ns();
    if (now_ns >= end_ns) break;
    found = ::poll(
        &ended, 1,
        static_cast<int>(std::min<std::uint64_t>((end_ns - now_ns) / 1'000'000 + 1, 60'000)));
  }
  has_hung = found <= 0;
  if (has_hung) ::kill(process, SIGKILL);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

/// The last lines that the process printed.
std::string last_words(int output) {
  std::array<char, 2048> text{};
  const off_t size = ::lseek(output, 0, SEEK_END);
  const off_t from = std::max<off_t>(0, size - static_cast<off_t>(text.size()));
  const ssize_t length = ::pread(output, text.data(), text.size(), from);
  std::string_view rest(text.data(), static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  std::string words;
  for (int lines = 0; lines < 3 && !rest.empty();) {
    while (rest.ends_with('\n')) rest.remove_suffix(1);
    const std::size_t start = rest.rfind('\n') + 1;  // npos + 1: the first line
    if (const std::string_view line = rest.substr(start); !line.empty()) {
      words = "it printed: " + std::string(line) + "\n" + words;
      ++lines;
    }
    rest = rest.substr(0, start);
  }
  return words;
}

/// How a process ended that was to end with status 0; empty if it did.
std::string unexpected_end(int status, bool has_hung, double timeout_s) {
  std::array<char, 64> text{};
  if (has_hung) {
    std::snprintf(text.data(), text.size(), "does not return within %g s from", timeout_s);
  } else if (WIFSIGNALED(status)) {
    const char* const name = ::sigabbrev_np(WTERMSIG(status));
    std::snprintf(text.data(), text.size(), "dies of SIG%s in", name == nullptr ? "?" : name);
  } else if (WEXITSTATUS(status) != EXIT_SUCCESS) {
    std::snprintf(text.data(), text.size(), "ends the process with status %d in",
                  WEXITSTATUS(status));
  }
  return text.data();
}

}  // namespace

ProcessOutcome run_in_process(std::vector<std::string> arguments, double timeout_s) {
  const SharedRecord record;
  const File output(::memfd_create("output", MFD_CLOEXEC));
  arguments.emplace_back(kRecordOption);
  arguments.push_back(std::to_string(record.file()));
  const pid_t process = ::fork();
  if (process < 0) fail("a process");
  if (process == 0) execute(arguments, output.get());

  ProcessOutcome outcome;
  const int status = wait_for(process, timeout_s, outcome.has_hung);
  outcome.fuzz_sequence = record->fuzz_sequence;
  outcome.verdict = record->verdict;
  outcome.line = record->line.data();
  outcome.details = record->details.data();
  std::string end = unexpected_end(status, outcome.has_hung, timeout_s);
  if (outcome.verdict == Verdict::kNone && end.empty()) end = "ends the process in";
  if (!end.empty() && outcome.verdict != Verdict::kFail) {
    outcome.verdict = Verdict::kFail;
    outcome.line = end + " " + record->step.data();
  }
  if (outcome.verdict == Verdict::kFail) outcome.details += last_words(output.get());
  return outcome;
}

bool run_here(const Check& check, const Subject& subject) {
  try {
    settle(check.run(subject));
  } catch (const CheckEnded&) {
    return false;
  } catch (const std::exception& error) {
    settle({Verdict::kFail, std::string("the check itself fails: ") + error.what(), {}});
    return false;
  }
  return check.process == CheckProcess::kExits;
}

}  // namespace stillgrid::device_check

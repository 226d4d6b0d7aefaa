#include "shared/realtime/guard/syscall_filter.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <iterator>

#include "shared/realtime/guard/violations.hpp"

// The one place from which the filter lets everything through.
asm(R"(
  .text
  .hidden stillgrid_guard_syscall
  .globl stillgrid_guard_syscall
  .type stillgrid_guard_syscall, @function
stillgrid_guard_syscall:
  .cfi_startproc
  movq %rdi, %rax
  movq %rsi, %rdi
  movq %rdx, %rsi
  movq %rcx, %rdx
  movq %r8, %r10
  movq %r9, %r8
  movq 8(%rsp), %r9
  syscall
  .hidden stillgrid_guard_after_syscall
  .globl stillgrid_guard_after_syscall
stillgrid_guard_after_syscall:
  ret
  .cfi_endproc
  .size stillgrid_guard_syscall, . - stillgrid_guard_syscall
)");
extern "C" [[gnu::visibility("hidden")]] long stillgrid_guard_syscall(long number, long a, long b,
                                                                      long c, long d, long e,
                                                                      long f) noexcept;
extern "C" [[gnu::visibility("hidden")]] const char stillgrid_guard_after_syscall;

namespace stillgrid::realtime {
namespace {

constexpr std::size_t kNumbers = 512;  // and one entry for all above
constinit std::array<Violation, kNumbers + 1> violations{};
constinit std::array<std::array<char, 24>, kNumbers> names_of_nameless{};

struct NamedNumber {
  std::size_t number;
  const char* name;
};
constexpr NamedNumber kNames[] = {
#include "shared/realtime/guard/syscall_names.inc"
};

[[gnu::constructor]] void name_system_calls() {
  for (std::size_t number = 0; number < kNumbers; ++number) {
    auto& name = names_of_nameless[number];
    std::snprintf(name.data(), name.size(), "system call %zu", number);
    violations[number].call = name.data();
  }
  violations[kNumbers].call = "system call above 511";
  for (const NamedNumber& named : kNames)
    if (named.number < kNumbers) violations[named.number].call = named.name;
}

/// A handler's end puts the mask back that it found. So a new mask is written there, but for
/// SIGSYS, which must stay open or the next trap ends the process.
void keep_signal_mask(ucontext_t& context) noexcept {
  std::uint64_t mask = 0;
  stillgrid_guard_syscall(SYS_rt_sigprocmask, SIG_BLOCK, 0, reinterpret_cast<long>(&mask),
                          sizeof mask, 0, 0);
  mask &= ~(std::uint64_t{1} << (SIGSYS - 1U));
  // The kernel's sigset is the first 8 of the library's 128 bytes; the rest is not in the frame.
  *reinterpret_cast<std::uint64_t*>(&context.uc_sigmask) = mask;
}

void on_trap(int /*signal*/, siginfo_t* info, void* argument) {
  constexpr int kBySeccomp = 1;  // SYS_SECCOMP, which glibc does not name
  if (info->si_code != kBySeccomp) return;
  auto& context = *static_cast<ucontext_t*>(argument);
  auto& registers = context.uc_mcontext.gregs;
  const long number = info->si_syscall;
  note(violations[std::min(static_cast<std::size_t>(number), kNumbers)]);
  // A vfork child would return through this frame and leave nothing of it to its parent.
  registers[REG_RAX] = stillgrid_guard_syscall(
      number == SYS_vfork ? SYS_fork : number, registers[REG_RDI], registers[REG_RSI],
      registers[REG_RDX], registers[REG_R10], registers[REG_R8], registers[REG_R9]);
  if (number == SYS_rt_sigprocmask) keep_signal_mask(context);
}

constexpr sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
constexpr sock_filter argument(std::size_t index) {
  return load(offsetof(seccomp_data, args) + index * 8);  // its low half
}
constexpr sock_filter jump_if_equal(std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, yes, no);
}
constexpr sock_filter skip_unless(std::uint32_t value, std::uint8_t count) {
  return jump_if_equal(value, 0, count);
}
constexpr std::uint32_t low(std::uintptr_t word) {
  return static_cast<std::uint32_t>(word);
}

int install_filter() noexcept {
  const auto stub = reinterpret_cast<std::uintptr_t>(&stillgrid_guard_after_syscall);
  constexpr std::size_t kAddress = offsetof(seccomp_data, instruction_pointer);
  constexpr std::uint32_t kInPlace = MAP_FIXED | MAP_PRIVATE | MAP_ANONYMOUS;
  constexpr sock_filter kAllow = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  constexpr sock_filter kTrap = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
  constexpr sock_filter kKill = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS);
  // clang-format off
  sock_filter program[] = {
      load(kAddress), skip_unless(low(stub), 3),
      load(kAddress + 4), skip_unless(low(stub >> 32U), 1), kAllow,
      load(offsetof(seccomp_data, arch)), jump_if_equal(AUDIT_ARCH_X86_64, 1, 0),
        kKill,  // a number of another architecture cannot be made by the stub
      load(offsetof(seccomp_data, nr)),
      skip_unless(SYS_clock_gettime, 1), kAllow,
      skip_unless(SYS_rt_sigreturn, 1), kAllow,
      skip_unless(SYS_restart_syscall, 1), kAllow,
      skip_unless(SYS_clone3, 1), kAllow,
      skip_unless(SYS_clock_nanosleep, 6),
        argument(0), skip_unless(CLOCK_MONOTONIC, 3),
        argument(1), skip_unless(TIMER_ABSTIME, 1), kAllow, kTrap,
      skip_unless(SYS_mmap, 7),
        argument(2), jump_if_equal(PROT_READ, 1, 0), skip_unless(PROT_READ | PROT_WRITE, 3),
        argument(3), skip_unless(kInPlace, 1), kAllow, kTrap,
      skip_unless(SYS_clone, 3),
        argument(0), BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, CLONE_VM, 0, 1), kAllow,
      kTrap};
  // clang-format on
  const sock_fprog filter{std::size(program), program};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return errno;
  return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &filter) == 0 ? 0 : errno;
}

}  // namespace

int filter_system_calls() noexcept {
  struct sigaction action {};
  action.sa_sigaction = on_trap;
  action.sa_flags = SA_SIGINFO | SA_RESTART | SA_NODEFER;
  ::sigemptyset(&action.sa_mask);
  return ::sigaction(SIGSYS, &action, nullptr) == 0 ? install_filter() : errno;
}

}  // namespace stillgrid::realtime

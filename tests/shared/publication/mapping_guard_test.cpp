#include "shared/publication/mapping_guard.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <thread>
#include <vector>

#include "shared/publication/segment.hpp"
#include "tests/shared/publication/test_session.hpp"

namespace stillgrid::publication::mapping_guard_test {
namespace {

constexpr std::size_t kBytes = 8 * 4096;

/// A mapped object of ones, which its owner may shrink.
class Mapped {
 public:
  explicit Mapped(int protection) : file_(::memfd_create("mapped", MFD_CLOEXEC)) {
    const std::vector<unsigned char> ones(kBytes, 1);
    REQUIRE(::write(file_.get(), ones.data(), kBytes) == ssize_t(kBytes));
    void* const start = ::mmap(nullptr, kBytes, protection, MAP_SHARED, file_.get(), 0);
    REQUIRE(start != MAP_FAILED);
    bytes_ = {static_cast<std::byte*>(start), kBytes};
  }
  ~Mapped() { ::munmap(bytes_.data(), kBytes); }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;

  [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }
  [[nodiscard]] int sum_of_pages() const {
    int sum = 0;
    for (std::size_t i = 0; i < kBytes; i += 4096)
      sum += static_cast<int>(*static_cast<volatile std::byte*>(&bytes_[i]));
    return sum;
  }
  void shrink() const { REQUIRE(::ftruncate(file_.get(), 4096) == 0); }

 private:
  FileDescriptor file_;
  std::span<std::byte> bytes_;
};

/// The signal that ended a child that runs call, or 0.
template <class Call>
int signal_that_ends(Call&& call) {
  const pid_t child = ::fork();
  if (child == 0) {
    for (const int number : {SIGBUS, SIGSEGV, SIGABRT}) std::signal(number, SIG_DFL);
    call();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST_CASE("Without a guard an object that is shrunk while mapped ends its reader",
          "[mapping_guard]") {
  const Mapped memory(PROT_READ);
  memory.shrink();
  CHECK(signal_that_ends([&] { static_cast<void>(memory.sum_of_pages()); }) == SIGBUS);
}

TEST_CASE("A guarded mapping of a shrunk object reads as zeros throughout", "[mapping_guard]") {
  const Mapped memory(PROT_READ);
  const MappingGuard guard(memory.bytes(), MappingGuard::Access::kRead);
  CHECK(memory.sum_of_pages() == 8);
  CHECK_FALSE(guard.is_lost());

  memory.shrink();

  CHECK(memory.sum_of_pages() == 1);  // the page that is left, then zeros
  CHECK(guard.is_lost());
  CHECK(memory.sum_of_pages() == 0);
}

TEST_CASE("A writer goes on in private memory when its object is shrunk", "[mapping_guard]") {
  const Mapped memory(PROT_READ | PROT_WRITE);
  const MappingGuard guard(memory.bytes(), MappingGuard::Access::kWrite);
  memory.shrink();

  for (std::byte& byte : memory.bytes()) byte = std::byte{7};

  CHECK(guard.is_lost());
  CHECK(memory.bytes().back() == std::byte{7});
}

TEST_CASE("Every thread outlives the loss", "[mapping_guard]") {
  const Mapped memory(PROT_READ);
  const MappingGuard guard(memory.bytes(), MappingGuard::Access::kRead);
  memory.shrink();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back([&] { (void)memory.sum_of_pages(); });
  for (std::thread& thread : threads) thread.join();
  CHECK(guard.is_lost());
}

TEST_CASE("A bus error elsewhere ends the program as before", "[mapping_guard]") {
  const Mapped guarded(PROT_READ), other(PROT_READ);
  const MappingGuard guard(guarded.bytes(), MappingGuard::Access::kRead);
  other.shrink();
  const pid_t child = ::fork();
  if (child == 0) {
    static_cast<void>(other.sum_of_pages());
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  const bool is_ended = WIFSIGNALED(status) || WEXITSTATUS(status) != 0;  // sanitizers exit
  CHECK(is_ended);
  CHECK_FALSE(guard.is_lost());
}

TEST_CASE("A mapping that is no longer guarded is no longer replaced", "[mapping_guard]") {
  const Mapped memory(PROT_READ);
  { const MappingGuard guard(memory.bytes(), MappingGuard::Access::kRead); }
  std::vector<MappingGuard> all;  // places in the table are free again
  for (std::size_t i = 0; i < MappingGuard::kMax; ++i)
    all.emplace_back(memory.bytes(), MappingGuard::Access::kRead);
  CHECK_THROWS(MappingGuard(memory.bytes(), MappingGuard::Access::kRead));
}

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define STILLGRID_THREAD_SANITIZER
#endif
#endif

TEST_CASE("A writer whose segment was shrunk is told so", "[mapping_guard]") {
#ifdef STILLGRID_THREAD_SANITIZER
  WARN("skipped: a fault within the sanitizer's own atomics never returns");
  return;
#endif
  const TestSession session;
  SegmentWriter writer(session.name(), small_spec());
  writer.announce();
  CHECK_NOTHROW(writer.require_whole());
  REQUIRE(::truncate(session.path(proto::SegmentKind::kScene).c_str(), 0) == 0);
  for (std::uint64_t n = 1; n < 5; ++n) publish_small(writer.buffer(), n);
  CHECK(refusal_of([&] { writer.require_whole(); }).find("was shrunk") != std::string::npos);
}

}  // namespace
}  // namespace stillgrid::publication::mapping_guard_test

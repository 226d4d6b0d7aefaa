#include "shared/tools/device_check/fuzz.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "shared/realtime/periodic_timer.hpp"
#include "shared/tools/device_check/check.hpp"
#include "shared/tools/device_check/checked_device.hpp"
#include "shared/tools/device_check/edge_buffer.hpp"

namespace stillgrid::device_check {
namespace {

/// A driver under random calls, and the little that must be known to say what it may answer.
struct Play {
  const Subject& subject;
  const stillgrid_device_api& api;
  stillgrid_device* device = nullptr;  // null: closed
  bool is_active = false;
  EdgeBuffer<stillgrid_device_descriptor> descriptor{};
  EdgeBuffer<stillgrid_device_state> state{};
  EdgeBuffer<stillgrid_device_listing> listing{};
};

void must_refuse(std::int32_t code, const char* what) {
  if (code >= 0) broken(std::string(what) + " answers " + code_name(code));
}

void must_work(std::int32_t code, const char* what) {
  if (code != STILLGRID_DEVICE_OK) broken(std::string(what) + " answers " + code_name(code));
}

/// The answer to a call that is in order only where `is_due`.
void judge(std::int32_t code, bool is_due, const char* what) {
  if (is_due) return must_work(code, what);
  must_refuse(code, what);
}

void open(Play& play, std::uint64_t /*random*/) {
  if (play.device != nullptr) return;
  must_work(play.api.open(play.subject.index, &play.device), "open() of a closed device");
  for (const device::DeviceOption& option : play.subject.options)
    must_work(play.api.configure(play.device, option.key.c_str(), option.value.c_str()),
              "configure() after open()");
}

void close(Play& play, std::uint64_t /*random*/) {
  stillgrid_device* const device = play.device;
  play.device = nullptr;
  play.is_active = false;
  play.api.close(device);
}

void activate(Play& play, std::uint64_t /*random*/) {
  const bool is_due = play.device != nullptr && !play.is_active;
  judge(play.api.activate(play.device), is_due, is_due ? "activate() in order" : "activate()");
  play.is_active = play.device != nullptr;
}

void deactivate(Play& play, std::uint64_t /*random*/) {
  judge(play.api.deactivate(play.device), play.is_active, "deactivate()");
  play.is_active = false;
}

void configure_unknown(Play& play, std::uint64_t random) {
  std::string key(random % 40, '\0');
  for (char& letter : key)
    letter = static_cast<char>(1 + (random = random * 6364136223846793005U + 1) % 127);
  must_refuse(play.api.configure(play.device, ("?" + key).c_str(), key.c_str()),
              "configure() of an unknown key");
}

/// A size of struct: none, too short, of this header, or longer.
template <class Struct>
std::size_t size_by(std::uint64_t random) {
  return random % (sizeof(Struct) / 8 + 8) * 8;
}

void describe(Play& play, std::uint64_t random) {
  auto* const out = play.descriptor.cut(size_by<stillgrid_device_descriptor>(random));
  (void)play.api.describe(play.device, out);
}

void read(Play& play, std::uint64_t random) {
  auto* const out = play.state.cut(size_by<stillgrid_device_state>(random));
  const std::int32_t code = play.api.read(play.device, realtime::monotonic_ns(), out);
  if (!play.is_active) must_refuse(code, "read() out of order");
}

void write(Play& play, std::uint64_t /*random*/) {
  constexpr std::array<double, 3> kZero{};  // somebody may hold the device
  const std::int32_t code =
      play.api.write(play.device, realtime::monotonic_ns(), kZero.data(), kZero.data());
  if (!play.is_active) must_refuse(code, "write() out of order");
}

void open_wrong(Play& play, std::uint64_t random) {
  stillgrid_device* other = nullptr;
  const auto index = static_cast<std::uint32_t>(1'000'000 + random % 1000);
  must_refuse(play.api.open(index, random % 2 == 0 ? &other : nullptr), "open() of no device");
}

void call_with_nulls(Play& play, std::uint64_t random) {
  constexpr std::array<double, 3> kZero{};
  switch (random % 5) {
    case 0:
      return must_refuse(play.api.describe(play.device, nullptr), "describe() to null");
    case 1:
      return must_refuse(play.api.read(play.device, realtime::monotonic_ns(), nullptr),
                         "read() to null");
    case 2:
      return must_refuse(
          play.api.write(play.device, realtime::monotonic_ns(), nullptr, kZero.data()),
          "write() of null");
    case 3:
      return must_refuse(play.api.configure(play.device, nullptr, nullptr), "configure() of null");
    default:
      return must_refuse(play.api.activate(nullptr), "activate() of null");
  }
}

void stop(Play& play, std::uint64_t /*random*/) {
  play.api.emergency_stop(play.device);
}

void ask(Play& play, std::uint64_t random) {
  if (play.api.strerror(play.device, static_cast<std::int32_t>(random % 20) - 10) == nullptr)
    broken("strerror() gives null");
  if (play.api.enumerate() < 0) broken("enumerate() fails");
}

/// What version 2 added, as far as the driver has it.
void serve(Play& play, std::uint64_t random) {
  const stillgrid_device_api& api = play.api;
  if (api.command != nullptr)
    must_refuse(api.command(play.device, "?", random % 2 == 0 ? "1" : nullptr), "command()");
  if (api.write_gripper != nullptr)
    judge(api.write_gripper(play.device, realtime::monotonic_ns(), 0.0), play.is_active,
          "write_gripper()");
  const bool is_idle = play.device != nullptr && !play.is_active;
  if (api.set_tick != nullptr)
    judge(api.set_tick(play.device, nullptr, nullptr), is_idle, "set_tick()");
  if (api.list != nullptr)
    (void)api.list(play.device, static_cast<std::uint32_t>(random % 4),
                   play.listing.cut(size_by<stillgrid_device_listing>(random)));
}

struct Move {
  const char* name;
  unsigned weight;
  void (*make)(Play& play, std::uint64_t random);
};

/// What is in order comes often, so that a sequence gets far into a life.
constexpr std::array kMoves = {
    Move{"open()", 6, open},
    Move{"activate()", 6, activate},
    Move{"read()", 6, read},
    Move{"write()", 6, write},
    Move{"deactivate()", 4, deactivate},
    Move{"close()", 2, close},
    Move{"emergency_stop()", 3, stop},
    Move{"configure(unknown key)", 3, configure_unknown},
    Move{"describe()", 2, describe},
    Move{"open(wrong)", 1, open_wrong},
    Move{"null arguments", 2, call_with_nulls},
    Move{"strerror(), enumerate()", 1, ask},
    Move{"command(), write_gripper(), set_tick(), list()", 2, serve},
};

struct FuzzCall {
  const Move* move;
  std::uint64_t random;
};

std::array<FuzzCall, kFuzzCalls> calls_of(std::uint64_t seed, std::uint64_t sequence) {
  std::seed_seq seeds{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U),
                      static_cast<std::uint32_t>(sequence)};
  std::mt19937_64 random(seeds);
  const unsigned all =
      std::accumulate(kMoves.begin(), kMoves.end(), 0U,
                      [](unsigned sum, const Move& move) { return sum + move.weight; });
  std::array<FuzzCall, kFuzzCalls> calls{};
  for (FuzzCall& call : calls) {
    auto pick = static_cast<unsigned>(random() % all);
    const Move* move = kMoves.data();
    while (pick >= move->weight) pick -= (move++)->weight;
    call = {move, random()};
  }
  return calls;
}

std::vector<std::size_t> every_call() {
  std::vector<std::size_t> all(kFuzzCalls);
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

void play_sequence(Play& play, std::uint64_t sequence, const std::vector<std::size_t>& kept) {
  this_record().fuzz_sequence = sequence;
  const auto calls = calls_of(play.subject.seed, sequence);
  for (const std::size_t n : kept) {
    const std::string step = std::string(calls.at(n).move->name) + " among random calls";
    call_driver(step.c_str(), [&] { calls.at(n).move->make(play, calls.at(n).random); });
  }
  if (play.device != nullptr) call_driver("close() after random calls", [&] { close(play, 0); });
}

Outcome check_order(const Subject& subject) {
  const stillgrid_device_api api = negotiate_table(subject, host_of_checks());
  Play play{subject, api};
  if (subject.fuzz_part) {
    play_sequence(play, subject.fuzz_part->sequence, subject.fuzz_part->calls);
    return {};
  }
  const auto enough = static_cast<std::uint64_t>(std::ceil(400.0 * subject.seconds));
  const std::uint64_t end_ns = realtime::monotonic_ns() + realtime::to_ns(subject.seconds);
  std::uint64_t sequence = 0;
  for (; sequence < enough && (sequence == 0 || realtime::monotonic_ns() < end_ns); ++sequence)
    play_sequence(play, sequence, every_call());
  return {Verdict::kPass,
          std::to_string(sequence) + " sequences of " + std::to_string(kFuzzCalls) + " calls",
          {}};
}

constexpr std::array kChecks = {
    Check{"fuzz.order", "survives random calls in random order",
          "life.* order.* arguments.* stop.* pace.* services.*", check_order},
};

}  // namespace

std::span<const Check> fuzz_checks() {
  return kChecks;
}

std::string fuzz_text(std::uint64_t seed, std::uint64_t sequence,
                      const std::vector<std::size_t>& kept) {
  const auto calls = calls_of(seed, sequence);
  std::string text;
  for (const std::size_t n : kept)
    text += (text.empty() ? "" : ", ") + std::string(calls.at(n).move->name);
  return text;
}

std::vector<std::size_t> shrink_calls(
    const std::function<bool(const std::vector<std::size_t>& kept)>& fails) {
  std::vector<std::size_t> kept = every_call();
  if (!fails(kept)) return {};
  int asked = 1;
  for (std::size_t chunk = kFuzzCalls / 2; chunk > 0; chunk /= 2) {
    for (std::size_t from = 0; from < kept.size() && asked < 200;) {
      std::vector<std::size_t> fewer = kept;
      const auto first = fewer.begin() + static_cast<std::ptrdiff_t>(from);
      fewer.erase(first, first + static_cast<std::ptrdiff_t>(std::min(chunk, kept.size() - from)));
      ++asked;
      if (!fewer.empty() && fails(fewer))
        kept = std::move(fewer);
      else
        from += chunk;
    }
  }
  return kept;
}

}  // namespace stillgrid::device_check

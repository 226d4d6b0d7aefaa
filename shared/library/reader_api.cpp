#include <utility>

#include "shared/library/handle.hpp"
#include "shared/library/known_part.hpp"
#include "shared/library/reader.hpp"
#include "shared/publication/hands.hpp"

struct stillgrid_reader {
  explicit stillgrid_reader(std::string hand_session) : own(std::move(hand_session)) {}
  stillgrid::library::HandleUse use;
  stillgrid::library::Reader own;
};

namespace stillgrid::library {
namespace {

int open(const char* session, const char* hand, stillgrid_reader** reader) {
  if (reader == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "reader: expected a place for the handle, not null");
  *reader = nullptr;
  std::string name = session == nullptr ? "default" : session;
  if (const std::string complaint = publication::settle_session(name); !complaint.empty())
    return fail(STILLGRID_E_ARGUMENT, "session: %s", complaint.c_str());
  if (hand != nullptr)
    if (const std::string complaint = publication::hand_complaint(hand); !complaint.empty())
      return fail(STILLGRID_E_ARGUMENT, "hand: %s", complaint.c_str());
  *reader = new stillgrid_reader(publication::hand_session(name, hand == nullptr ? "" : hand));
  return STILLGRID_OK;
}

/// A call that fills in a struct: of what the caller gave of it, back to what the caller knows.
template <class Struct, class Call>
int fill(stillgrid_reader* reader, Struct* given, const char* name, Call&& call) noexcept {
  return with_handle(reader, "reader", [&](Reader& own) {
    Struct known;
    if (const int code = take_known(given, name, sizeof(Struct), known)) return code;
    const int code = call(own, known);
    if (code == STILLGRID_OK) give_known(known, given);
    return code;
  });
}

}  // namespace
}  // namespace stillgrid::library

using stillgrid::library::fill;
using stillgrid::library::Reader;

int stillgrid_reader_open(const char* session, const char* hand, stillgrid_reader** reader) {
  return stillgrid::library::guarded(
      [&] { return stillgrid::library::open(session, hand, reader); });
}

void stillgrid_reader_close(stillgrid_reader* reader) {
  stillgrid::library::close_handle(reader);
}

int stillgrid_reader_poll(stillgrid_reader* reader, stillgrid_session_state* state) {
  return fill(reader, state, "state", [](Reader& own, auto& told) { return own.poll(told); });
}

int stillgrid_reader_fixed(stillgrid_reader* reader, stillgrid_fixed* fixed) {
  return fill(reader, fixed, "fixed", [](Reader& own, auto& told) { return own.fixed(told); });
}

int stillgrid_reader_snapshot(stillgrid_reader* reader, stillgrid_snapshot* snapshot) {
  return fill(reader, snapshot, "snapshot",
              [](Reader& own, auto& told) { return own.snapshot(told); });
}

int stillgrid_reader_static(stillgrid_reader* reader, stillgrid_snapshot* snapshot) {
  return fill(reader, snapshot, "snapshot",
              [](Reader& own, auto& told) { return own.static_spheres(told); });
}

int stillgrid_reader_displayed(stillgrid_reader* reader, stillgrid_snapshot* snapshot) {
  return fill(reader, snapshot, "snapshot",
              [](Reader& own, auto& told) { return own.displayed(told); });
}

int stillgrid_reader_tool(stillgrid_reader* reader, stillgrid_tool* tool) {
  return fill(reader, tool, "tool", [](Reader& own, auto& told) { return own.tool(told); });
}

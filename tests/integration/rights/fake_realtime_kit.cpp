// org.freedesktop.RealtimeKit1 as a test wants it: fake_realtime_kit MODE, on the bus of
// DBUS_SYSTEM_BUS_ADDRESS, until it is killed. As root it really grants.
#include <sched.h>
#include <systemd/sd-bus.h>

#include <cstdint>
#include <cstdio>
#include <cstring>

namespace {

const char* mode = "grants";

bool is(const char* wanted) {
  return std::strcmp(mode, wanted) == 0;
}

int get_priority(sd_bus*, const char*, const char*, const char*, sd_bus_message* reply, void*,
                 sd_bus_error*) {
  return sd_bus_message_append(reply, "i", is("says_99") ? 99 : is("says_minus_1") ? -1 : 20);
}

int get_time(sd_bus*, const char*, const char*, const char*, sd_bus_message* reply, void*,
             sd_bus_error*) {
  return sd_bus_message_append(reply, "x",
                               is("says_no_time") ? std::int64_t{-5} : std::int64_t{200'000});
}

int make_realtime(sd_bus_message* call, void*, sd_bus_error* error) {
  std::uint64_t thread = 0;
  std::uint32_t priority = 0;
  const int code = sd_bus_message_read(call, "tu", &thread, &priority);
  if (code < 0) return code;
  if (is("refuses"))
    return sd_bus_error_set(error, SD_BUS_ERROR_ACCESS_DENIED, "the session is not active");
  if (is("hangs")) return 1;  // no reply, ever
  if (!is("does_nothing")) {
    sched_param wanted{};
    wanted.sched_priority = static_cast<int>(priority);
    if (priority > 20 || sched_setscheduler(static_cast<pid_t>(thread),
                                            SCHED_RR | SCHED_RESET_ON_FORK, &wanted) != 0)
      return sd_bus_error_set(error, SD_BUS_ERROR_FAILED, "the fake could not");
  }
  return sd_bus_reply_method_return(call, "");
}

const sd_bus_vtable kInterface[] = {
    SD_BUS_VTABLE_START(0),
    SD_BUS_PROPERTY("MaxRealtimePriority", "i", get_priority, 0, SD_BUS_VTABLE_PROPERTY_CONST),
    SD_BUS_PROPERTY("RTTimeUSecMax", "x", get_time, 0, SD_BUS_VTABLE_PROPERTY_CONST),
    SD_BUS_METHOD("MakeThreadRealtime", "tu", "", make_realtime, SD_BUS_VTABLE_UNPRIVILEGED),
    SD_BUS_VTABLE_END};

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) mode = argv[1];
  sd_bus* bus = nullptr;
  if (sd_bus_open_system(&bus) < 0 ||
      sd_bus_add_object_vtable(bus, nullptr, "/org/freedesktop/RealtimeKit1",
                               "org.freedesktop.RealtimeKit1", kInterface, nullptr) < 0 ||
      sd_bus_request_name(bus, "org.freedesktop.RealtimeKit1", 0) < 0) {
    std::fprintf(stderr, "fake_realtime_kit: no bus\n");
    return 1;
  }
  std::puts("ready");
  std::fflush(stdout);
  for (;;) {
    const int done = sd_bus_process(bus, nullptr);
    if (done < 0 || (done == 0 && sd_bus_wait(bus, UINT64_MAX) < 0)) return 1;
  }
}

#include <new>

#include "shared/library/handle.hpp"
#include "shared/library/known_part.hpp"
#include "shared/library/last_error.hpp"
#include "shared/library/publisher.hpp"
#include "shared/library/scene_checks.hpp"

struct stillgrid_publisher {
  template <class... Arguments>
  explicit stillgrid_publisher(Arguments&&... arguments)
      : own(std::forward<Arguments>(arguments)...) {}
  stillgrid::library::HandleUse use;
  stillgrid::library::Publisher own;
};

namespace stillgrid::library {
namespace {

constexpr std::size_t kMaxSpheres = std::size_t{1} << 24U;

int open(const stillgrid_scene* given, stillgrid_publisher** publisher) {
  if (publisher == nullptr)
    return fail(STILLGRID_E_ARGUMENT, "publisher: expected a place for the handle, not null");
  *publisher = nullptr;
  stillgrid_scene scene;
  if (const int code = take_known(given, "scene", sizeof(stillgrid_scene), scene)) return code;
  if (scene.sphere_capacity > kMaxSpheres)
    return fail(STILLGRID_E_CAPACITY, "scene.sphere_capacity: %u: expected %zu at most",
                scene.sphere_capacity, kMaxSpheres);
  publication::SessionSpec spec;
  std::vector<publication::HandScene> hands;
  if (const int code = read_scene(scene, spec, hands)) return code;
  spec.start_ns = spec.clock == proto::Clock::kVirtual ? 0 : realtime::monotonic_ns();
  *publisher = new stillgrid_publisher(spec, hands);
  return STILLGRID_OK;
}

template <class Call>
int with(stillgrid_publisher* publisher, Call&& call) noexcept {
  return with_handle(publisher, "publisher", call);
}

int null_argument(const char* name) {
  return fail(STILLGRID_E_ARGUMENT, "%s: expected a place to read or write, not null", name);
}

}  // namespace
}  // namespace stillgrid::library

using stillgrid::library::fail;
using stillgrid::library::Publisher;

uint32_t stillgrid_api_version(void) {
  return STILLGRID_API_VERSION;
}

const char* stillgrid_library_version(void) {
  return STILLGRID_VERSION;
}

int stillgrid_publisher_open(const stillgrid_scene* scene, stillgrid_publisher** publisher) {
  return stillgrid::library::guarded([&] { return stillgrid::library::open(scene, publisher); });
}

void stillgrid_publisher_close(stillgrid_publisher* publisher) {
  stillgrid::library::close_handle(publisher);
}

int stillgrid_publisher_wait(stillgrid_publisher* publisher, uint64_t* time_ns) {
  if (time_ns == nullptr) return stillgrid::library::null_argument("time_ns");
  return stillgrid::library::with(publisher, [&](Publisher& own) { return own.wait(*time_ns); });
}

int stillgrid_publisher_set_shapes(stillgrid_publisher* publisher, const stillgrid_shapes* shapes) {
  return stillgrid::library::with(publisher, [&](Publisher& own) {
    stillgrid_shapes known;
    if (const int code =
            stillgrid::library::take_known(shapes, "shapes", sizeof(stillgrid_shapes), known))
      return code;
    return own.set_shapes(known);
  });
}

int stillgrid_publisher_set_spheres(stillgrid_publisher* publisher, uint32_t count,
                                    const double* positions_m, const double* velocities_m_s) {
  return stillgrid::library::with(publisher, [&](Publisher& own) {
    return own.set_spheres(count, positions_m, velocities_m_s);
  });
}

int stillgrid_publisher_set_responses(stillgrid_publisher* publisher, uint32_t count,
                                      const stillgrid_response* responses) {
  if (responses == nullptr && count > 0) return stillgrid::library::null_argument("responses");
  return stillgrid::library::with(publisher, [&](Publisher& own) {
    return own.set_responses({responses, count});
  });
}

int stillgrid_publisher_pushes(stillgrid_publisher* publisher, double step_s,
                               stillgrid_push* pushes, uint32_t* count) {
  if (count == nullptr || (pushes == nullptr && *count > 0))
    return stillgrid::library::null_argument(count == nullptr ? "count" : "pushes");
  return stillgrid::library::with(publisher, [&](Publisher& own) {
    return own.find_pushes(step_s, {pushes, *count}, *count);
  });
}

int stillgrid_publisher_publish(stillgrid_publisher* publisher, uint64_t state_time_ns) {
  return stillgrid::library::with(publisher,
                                  [&](Publisher& own) { return own.publish(state_time_ns); });
}

int stillgrid_publisher_tool(stillgrid_publisher* publisher, uint32_t hand, stillgrid_tool* tool) {
  if (tool == nullptr) return stillgrid::library::null_argument("tool");
  if (tool->struct_size < sizeof(stillgrid_tool))
    return fail(STILLGRID_E_ARGUMENT, "tool.struct_size: %u: expected sizeof, %zu or more",
                tool->struct_size, sizeof(stillgrid_tool));
  return stillgrid::library::with(publisher,
                                  [&](Publisher& own) { return own.take_tool(hand, *tool); });
}

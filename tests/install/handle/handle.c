/* A simulated handle for Stillgrid: a mass on a spring, free along z. One file, C11. */
#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <stillgrid/device_plugin.h>
#include <string.h>

#define MASS_KG 0.1
#define DAMPING_N_S_PER_M 2.0
#define MAX_FORCE_N 3.0
#define NEVER UINT64_MAX

/* The host sees no more of it than a pointer. */
struct stillgrid_device {
  double rest_z_m, stiffness_N_per_m; /* options: where the spring pulls to, and how hard */
  bool is_active;
  atomic_bool is_stopped; /* emergency_stop() comes from any thread, also during a read() */
  uint64_t time_ns;       /* of the state below, or NEVER before the first read */
  uint64_t sequence;
  double z_m, velocity_m_s, force_N;
  const char* error; /* the line that strerror() gives, or null */
};

static int32_t handle_enumerate(void) {
  return 1;
}

static int32_t handle_open(uint32_t index, stillgrid_device** out) {
  if (out == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  *out = NULL;
  if (index != 0) return STILLGRID_DEVICE_E_NO_DEVICE;
  stillgrid_device* device = calloc(1, sizeof *device);
  if (device == NULL) return STILLGRID_DEVICE_E_IO;
  device->rest_z_m = -0.02;
  device->stiffness_N_per_m = 50.0;
  *out = device;
  return STILLGRID_DEVICE_OK;
}

/* One option of --device handle:rest_z_m=-0.03,stiffness_N_per_m=100 */
static int32_t handle_configure(stillgrid_device* device, const char* key, const char* value) {
  if (device == NULL || key == NULL || value == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  if (device->is_active) return STILLGRID_DEVICE_E_ORDER;
  char* end = NULL;
  const double number = strtod(value, &end);
  const bool is_number = end != value && *end == '\0' && isfinite(number);
  if (strcmp(key, "rest_z_m") == 0 && is_number && fabs(number) <= 0.06) {
    device->rest_z_m = number;
  } else if (strcmp(key, "stiffness_N_per_m") == 0 && is_number && number > 0.0 &&
             number <= 1000.0) {
    device->stiffness_N_per_m = number;
  } else { /* the host has named key and value */
    device->error = "expected rest_z_m from -0.06 to 0.06, or stiffness_N_per_m above 0, to 1000";
    return STILLGRID_DEVICE_E_ARGUMENT;
  }
  return STILLGRID_DEVICE_OK;
}

static int32_t handle_describe(stillgrid_device* device, stillgrid_device_descriptor* out) {
  if (device == NULL || out == NULL || out->struct_size != sizeof *out)
    return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_descriptor d = {.struct_size = sizeof d}; /* zero: unknown, or no such limit */
  strcpy(d.name, "handle");
  d.flags = STILLGRID_DEVICE_NO_MOTORS; /* it is simulated; a real device leaves this out */
  for (int axis = 0; axis < 3; ++axis) {
    d.workspace_min_m[axis] = -0.08;
    d.workspace_max_m[axis] = 0.08;
  }
  d.max_force_N = MAX_FORCE_N;
  d.rate_hz = 1000.0;
  d.max_read_ns = 50000;
  *out = d;
  return STILLGRID_DEVICE_OK;
}

static int32_t handle_activate(stillgrid_device* device) {
  if (device == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  if (device->is_active) return STILLGRID_DEVICE_E_ORDER;
  device->is_active = true;
  device->is_stopped = false;
  device->time_ns = NEVER;
  device->sequence = 0;
  device->z_m = 0.04; /* let go from here */
  device->velocity_m_s = device->force_N = 0.0;
  return STILLGRID_DEVICE_OK;
}

/* Moves the handle to now_ns. After a stall it goes on from where it was: catching up would take
 * long, and would throw the handle about. */
static void advance(stillgrid_device* device, uint64_t now_ns) {
  if (device->is_stopped) device->force_N = 0.0;
  if (device->time_ns == NEVER) device->time_ns = now_ns;
  if (now_ns <= device->time_ns) return;
  double left_s = fmin((double)(now_ns - device->time_ns) * 1e-9, 0.01);
  device->time_ns = now_ns;
  while (left_s > 0.0) {
    const double step_s = fmin(left_s, 1e-4);
    const double spring_N = device->stiffness_N_per_m * (device->rest_z_m - device->z_m);
    const double total_N = spring_N - DAMPING_N_S_PER_M * device->velocity_m_s + device->force_N;
    device->velocity_m_s += step_s * total_N / MASS_KG;
    device->z_m += step_s * device->velocity_m_s;
    left_s -= step_s;
  }
}

static int32_t handle_read(stillgrid_device* device, uint64_t now_ns, stillgrid_device_state* out) {
  if (device == NULL || out == NULL || out->struct_size != sizeof *out)
    return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  advance(device, now_ns);
  stillgrid_device_state state = {.struct_size = sizeof state};
  state.valid = STILLGRID_STATE_POSITION;
  state.time_ns = now_ns; /* a real device: when its encoders were sampled */
  state.sequence = ++device->sequence;
  state.position_m[2] = device->z_m;
  *out = state;
  return STILLGRID_DEVICE_OK;
}

/* The host has limited the force already. Hardware deserves a driver that does not rely on it. */
static int32_t handle_write(stillgrid_device* device, uint64_t now_ns, const double force_N[3],
                            const double torque_N_m[3]) {
  (void)torque_N_m; /* has no motors for it; may be null */
  if (device == NULL || force_N == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  advance(device, now_ns); /* until now, under the force before */
  const double z_N = isfinite(force_N[2]) ? force_N[2] : 0.0;
  device->force_N = device->is_stopped ? 0.0 : fmax(-MAX_FORCE_N, fmin(MAX_FORCE_N, z_N));
  return STILLGRID_DEVICE_OK;
}

static int32_t handle_deactivate(stillgrid_device* device) {
  if (device == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  if (!device->is_active) return STILLGRID_DEVICE_E_ORDER;
  device->is_active = false;
  device->force_N = 0.0; /* a real device: motors off */
  return STILLGRID_DEVICE_OK;
}

static void handle_close(stillgrid_device* device) {
  free(device);
}

static void handle_emergency_stop(stillgrid_device* device) {
  if (device != NULL) device->is_stopped = true;
}

static const char* handle_strerror(stillgrid_device* device, int32_t code) {
  if (code == STILLGRID_DEVICE_E_ORDER) return "call not allowed in this state of life";
  if (code == STILLGRID_DEVICE_E_NO_DEVICE) return "there is only device 0";
  if (code == STILLGRID_DEVICE_E_IO) return "out of memory";
  if (code == STILLGRID_DEVICE_E_ARGUMENT && device != NULL && device->error != NULL)
    return device->error;
  return code == STILLGRID_DEVICE_OK ? "done" : "null or bad argument";
}

int32_t stillgrid_device_negotiate(const stillgrid_host_info* host, stillgrid_device_api* out) {
  if (host == NULL || out == NULL) return STILLGRID_DEVICE_E_ARGUMENT;
  if (host->abi != STILLGRID_DEVICE_ABI) return STILLGRID_DEVICE_E_VERSION;
  if (host->struct_size != sizeof *host || out->struct_size != sizeof *out)
    return STILLGRID_DEVICE_E_ARGUMENT;
  stillgrid_device_api api = {.struct_size = sizeof api, .abi = STILLGRID_DEVICE_ABI};
  api.enumerate = handle_enumerate;
  api.open = handle_open;
  api.configure = handle_configure;
  api.describe = handle_describe;
  api.activate = handle_activate;
  api.read = handle_read;
  api.write = handle_write;
  api.deactivate = handle_deactivate;
  api.close = handle_close;
  api.emergency_stop = handle_emergency_stop;
  api.strerror = handle_strerror;
  *out = api;
  return STILLGRID_DEVICE_OK;
}

/* The contract between haptic_server and a device driver: a C ABI.
 *
 * A driver is a shared library that exports one symbol, stillgrid_device_negotiate. Host and driver
 * must be built with the same STILLGRID_DEVICE_ABI. Every struct begins with struct_size, its
 * sizeof, set by the side that owns the buffer; the other side rejects a struct of any other size
 * and touches nothing behind it. No exception crosses the border. The caller owns every buffer.
 * Codes: 0 done, negative an error that strerror() explains. Frames: positions, orientations and
 * forces are in the device's own frame, SI units.
 *
 * Life: negotiate -> enumerate -> open -> configure* -> activate -> (read, write)* -> deactivate ->
 * close. A driver answers a call out of this order with STILLGRID_DEVICE_E_ORDER. [main] functions
 * may block and allocate; they come from one thread. [realtime] functions neither allocate nor
 * lock, make no system call that the driver did not declare, and return within max_read_ns; they
 * come from one thread, between activate and deactivate. [any] may be called from every thread at
 * any time between open and close.
 *
 * Pace: the host's thread calls read and write once a period. Where a vendor's library has the
 * device served from a thread of its own, the driver declares STILLGRID_DEVICE_SETS_PACE: the host
 * gives it a tick before activate, the driver's thread calls that once a period, and inside it the
 * host calls read and write. So a force is of the position just read, and not a period old.
 *
 * Extensions: each side asks the other for a table by name and gets null where there is none. A
 * name ends in its version.
 */
#ifndef STILLGRID_PROTO_DEVICE_PLUGIN_H
#define STILLGRID_PROTO_DEVICE_PLUGIN_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Grows with every change of this file's layout or meaning. */
#define STILLGRID_DEVICE_ABI 2u

#define STILLGRID_DEVICE_NAME_SIZE 64u

/* Result codes. */
#define STILLGRID_DEVICE_OK 0
#define STILLGRID_DEVICE_E_VERSION (-1)  /* another STILLGRID_DEVICE_ABI */
#define STILLGRID_DEVICE_E_ARGUMENT (-2) /* unknown key, bad value, null or short buffer */
#define STILLGRID_DEVICE_E_ORDER (-3)    /* call not allowed in this state of life */
#define STILLGRID_DEVICE_E_NO_DEVICE (-4)
#define STILLGRID_DEVICE_E_IO (-5) /* the device stopped answering */
#define STILLGRID_DEVICE_END (-6)  /* a recording came to its end: not a fault */

/* Fields of stillgrid_device_state that the driver filled in. */
#define STILLGRID_STATE_POSITION 1u
#define STILLGRID_STATE_ORIENTATION 2u
#define STILLGRID_STATE_VELOCITY 4u
#define STILLGRID_STATE_BUTTONS 8u
#define STILLGRID_STATE_TEMPERATURE 16u
#define STILLGRID_STATE_GRIPPER 32u
#define STILLGRID_STATE_AXES 64u

/* Status of a device: bits of status, each of them told only where status_known has it too. Where
 * motors are off, an enabling switch is open, encoders have no reference or the device is hot or at
 * fault the host commands no force; afterwards it ramps in from zero. */
#define STILLGRID_STATUS_MOTORS_ON 1u
#define STILLGRID_STATUS_ENABLED 2u    /* dead-man, pedal or grip sensor: a hand wants force */
#define STILLGRID_STATUS_CALIBRATED 4u /* positions have their reference; not so while homing */
#define STILLGRID_STATUS_HOT 8u        /* the motors are too hot to be driven on */
#define STILLGRID_STATUS_FAULT 16u     /* one that the device itself has found */

/* How the host counts time. */
#define STILLGRID_CLOCK_MONOTONIC 0u /* CLOCK_MONOTONIC, ns */
#define STILLGRID_CLOCK_VIRTUAL 1u   /* lockstep: starts at 0, advances one period a tick */

/* Driver flags. */
#define STILLGRID_DEVICE_USES_SYSCALLS 1u /* read or write enter the kernel (USB, ...) */
/* Simulated, recorded or input alone: no force stays on a hand, whatever becomes of the program.
 * Only such a device runs in virtual time; any other is released when the program ended without it.
 */
#define STILLGRID_DEVICE_NO_MOTORS 2u
/* The driver calls the tick that set_tick() gave it. Given none (in virtual time) it is called by
 * the host as any other. */
#define STILLGRID_DEVICE_SETS_PACE 4u

/* Degrees of freedom, in the device's own frame: translation along and rotation about its axes. */
#define STILLGRID_DOF_X 1u
#define STILLGRID_DOF_Y 2u
#define STILLGRID_DOF_Z 4u
#define STILLGRID_DOF_ABOUT_X 8u
#define STILLGRID_DOF_ABOUT_Y 16u
#define STILLGRID_DOF_ABOUT_Z 32u
#define STILLGRID_DOF_GRIPPER 64u

#define STILLGRID_AXES_SIZE 4u

typedef struct stillgrid_host_info {
  uint32_t struct_size;
  uint32_t abi;   /* STILLGRID_DEVICE_ABI */
  uint32_t clock; /* STILLGRID_CLOCK_... */
  uint32_t reserved;
  uint64_t period_ns; /* of the haptic loop */
  /* [main] A table of the host's by its name, or null. Good for as long as the process lives; the
   * host info itself only until negotiate returns. */
  const void* (*get_extension)(const char* name);
} stillgrid_host_info;

/* What a device is; zero where a figure is unknown or has no limit. */
typedef struct stillgrid_device_descriptor {
  uint32_t struct_size;
  uint32_t flags;                        /* STILLGRID_DEVICE_... */
  char name[STILLGRID_DEVICE_NAME_SIZE]; /* zero-terminated */
  double workspace_min_m[3];
  double workspace_max_m[3];
  double position_resolution_m;
  double max_force_N;               /* for a moment */
  double continuous_force_N;        /* for ever: what the motors' heat allows */
  double nominal_stiffness_N_per_m; /* greatest stiffness that the maker advises to render */
  double rate_hz;
  uint64_t max_read_ns;         /* longest that read() or write() may take */
  double motor_time_constant_s; /* thermal, over which max_force_N may exceed continuous_force_N */
  double max_speed_m_s;         /* above it positions or motors are not to be trusted */
  double max_torque_N_m; /* for a moment, about the tool's origin; 0: as max_force_N at 0.1 m */
  double continuous_torque_N_m; /* for ever: over the same time constant as the force */
  uint32_t dof_sensed;          /* STILLGRID_DOF_..., zero: not told */
  uint32_t dof_actuated;        /* where they are told the host commands nothing along the others */
  uint32_t button_count;
  uint32_t axis_count;   /* analogue axes, up to STILLGRID_AXES_SIZE */
  double gripper_open_m; /* the widest opening of a gripper; closed is zero */
  double max_gripper_force_N;
} stillgrid_device_descriptor;

typedef struct stillgrid_device_state {
  uint32_t struct_size;
  uint32_t valid;    /* STILLGRID_STATE_... */
  uint64_t time_ns;  /* when the state was sampled, host's clock */
  uint64_t sequence; /* grows with each fresh sample */
  double position_m[3];
  double orientation_xyzw[4]; /* unit quaternion, device from tool */
  double velocity_m_s[3];     /* the driver's estimate; the host makes its own */
  uint32_t buttons;           /* one bit each */
  uint32_t reserved;
  uint32_t status;                  /* STILLGRID_STATUS_... */
  uint32_t status_known;            /* which of them the device tells */
  double temperature_C;             /* of its hottest motor */
  double gripper_m;                 /* how far the gripper is open */
  double axes[STILLGRID_AXES_SIZE]; /* analogue, -1 to 1 */
} stillgrid_device_state;

typedef struct stillgrid_device stillgrid_device; /* opaque, owned by the driver */

/* One device that a driver sees. */
typedef struct stillgrid_device_listing {
  uint32_t struct_size;
  uint32_t reserved;
  char name[STILLGRID_DEVICE_NAME_SIZE]; /* zero-terminated UTF-8, as are the others */
  char serial[STILLGRID_DEVICE_NAME_SIZE];
  char options[2u * STILLGRID_DEVICE_NAME_SIZE]; /* key=value,... that open this one */
} stillgrid_device_listing;

/* The host's tick. Zero; anything else ends the ticks until the next activate(). */
typedef int32_t (*stillgrid_device_tick_fn)(void* context);

typedef struct stillgrid_device_api {
  uint32_t struct_size;
  uint32_t abi; /* STILLGRID_DEVICE_ABI */

  /* [main] Number of devices present, or a negative code. */
  int32_t (*enumerate)(void);
  /* [main] Opens device number index. */
  int32_t (*open)(uint32_t index, stillgrid_device** out);
  /* [main] Sets one option, before activate(). Both strings zero-terminated UTF-8. */
  int32_t (*configure)(stillgrid_device* device, const char* key, const char* value);
  /* [main] Fills in the descriptor; valid once configured. */
  int32_t (*describe)(stillgrid_device* device, stillgrid_device_descriptor* out);
  /* [main] Motors on, force zero. */
  int32_t (*activate)(stillgrid_device* device);
  /* [realtime] The state at time now_ns. */
  int32_t (*read)(stillgrid_device* device, uint64_t now_ns, stillgrid_device_state* out);
  /* [realtime] The force on the user's hand from now on, until the next write. */
  int32_t (*write)(stillgrid_device* device, uint64_t now_ns, const double force_N[3],
                   const double torque_N_m[3]);
  /* [main] Leaves zero force; the device may be activated again. */
  int32_t (*deactivate)(stillgrid_device* device);
  /* [main] Frees the device. */
  void (*close)(stillgrid_device* device);
  /* [any] Zero force at once, until the next activate(). */
  void (*emergency_stop)(stillgrid_device* device);
  /* [main] One line on the last error of this device (or of the library when null). Never null. */
  const char* (*strerror)(stillgrid_device* device, int32_t code);
  /* [main] A table of the driver's by its name, or null. May itself be null: no extensions. */
  const void* (*get_extension)(const char* name);

  /* Each of these may be null. */
  /* [main] For a device that declares STILLGRID_DEVICE_SETS_PACE: the tick that its thread calls
   * once a period, never two at a time, from activate() on until deactivate() has returned, which
   * waits for the last. Before activate(). Null takes the pace back. */
  int32_t (*set_tick)(stillgrid_device* device, stillgrid_device_tick_fn tick, void* context);
  /* [main] Device number index of those that the driver sees with its options as they are, or
   * STILLGRID_DEVICE_E_NO_DEVICE after the last. Before activate(); no device is moved by it. */
  int32_t (*list)(stillgrid_device* device, uint32_t index, stillgrid_device_listing* out);
  /* An order to an active device, such as a lamp's, while ticks go on: from a thread that is not
   * theirs, one at a time, and never while activate() or deactivate() runs. It returns soon. */
  int32_t (*command)(stillgrid_device* device, const char* key, const char* value);
  /* [realtime] The force on the gripper's fingers from now on; positive opens it. */
  int32_t (*write_gripper)(stillgrid_device* device, uint64_t now_ns, double force_N);
} stillgrid_device_api;

/* Extension of the host: lines for the user, printed with the driver's name before them. */
#define STILLGRID_HOST_LOG "stillgrid.host.log/1"
#define STILLGRID_LOG_INFO 0u
#define STILLGRID_LOG_WARNING 1u
typedef struct stillgrid_host_log {
  uint32_t struct_size;
  uint32_t reserved;
  /* Any thread but the real-time one. One line, zero-terminated UTF-8, copied at once. */
  void (*log)(uint32_t severity, const char* line);
} stillgrid_host_log;

/* Extension of the host: its session. Null if it has no session. */
#define STILLGRID_HOST_SESSION "stillgrid.host.session/1"
typedef struct stillgrid_host_session {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name; /* zero-terminated, SESSION or SESSION+HAND */
} stillgrid_host_session;

/* Extension of a driver: which device this is, for reports and recordings. */
#define STILLGRID_DEVICE_IDENTITY "stillgrid.device.identity/1"
#define STILLGRID_IDENTITY_SIZE 64u
typedef struct stillgrid_device_identity {
  uint32_t struct_size;
  uint32_t reserved;
  char serial[STILLGRID_IDENTITY_SIZE]; /* zero-terminated UTF-8, as are the others */
  char firmware[STILLGRID_IDENTITY_SIZE];
  char driver[STILLGRID_IDENTITY_SIZE]; /* name and version of the driver itself */
} stillgrid_device_identity;
typedef struct stillgrid_device_identity_api {
  uint32_t struct_size;
  uint32_t reserved;
  /* [main] Fills in what is known, once configured; empty where it is not. */
  int32_t (*identify)(stillgrid_device* device, stillgrid_device_identity* out);
} stillgrid_device_identity_api;

/* [main] The only exported symbol. Fills in out and returns STILLGRID_DEVICE_OK. */
typedef int32_t (*stillgrid_device_negotiate_fn)(const stillgrid_host_info* host,
                                                 stillgrid_device_api* out);

#if defined(__GNUC__)
#define STILLGRID_DEVICE_EXPORT __attribute__((visibility("default")))
#else
#define STILLGRID_DEVICE_EXPORT
#endif
STILLGRID_DEVICE_EXPORT int32_t stillgrid_device_negotiate(const stillgrid_host_info* host,
                                                           stillgrid_device_api* out);

#ifdef __cplusplus
}
#endif

#endif /* STILLGRID_PROTO_DEVICE_PLUGIN_H */

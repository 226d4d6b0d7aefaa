/* libstillgrid: any simulation may publish, any program may read. A C ABI, version 3.
 *
 * A simulation publishes its scene as spheres and planes into a session's shared memory; a
 * haptic_server of that session computes the force on the hand at 1 kHz against the newest
 * snapshot, whatever the simulation's own rate. A reader sees what the two publish. The layout of
 * the memory stays behind this library and may change with it; this header only grows.
 *
 * Units are SI. Frame: the scene's, one for all; device poses say where a device stands in it.
 * Quaternions are x, y, z, w. Arrays belong to the caller and are read or written during the call
 * alone. Structs that begin with struct_size may grow at their end: set it to sizeof; the others
 * never change.
 *
 * Errors: each call returns STILLGRID_OK, STILLGRID_NOTHING or a negative STILLGRID_E_...; then
 * stillgrid_last_error() says in one line what was wrong, with what was expected. A call that
 * failed has changed nothing. No exception, signal or exit leaves the library.
 *
 * Threads: a handle is used by one thread at a time; a second one inside it at once gets
 * STILLGRID_E_THREAD, and a close() waits for it. A child of a fork may not use its parent's
 * handles (STILLGRID_E_ORDER); closing them there does nothing. Different handles share nothing.
 * [main] calls may block and allocate. [step] calls allocate nothing, take no lock and wait for
 * nobody.
 */
#ifndef STILLGRID_PROTO_STILLGRID_H
#define STILLGRID_PROTO_STILLGRID_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define STILLGRID_API __attribute__((visibility("default")))
#else
#define STILLGRID_API
#endif

#define STILLGRID_API_VERSION 3u

/* Result codes. */
#define STILLGRID_OK 0
#define STILLGRID_NOTHING 1       /* no error: there is none yet, or no longer */
#define STILLGRID_AGAIN 2         /* no error: nothing came for 100 ms; call again */
#define STILLGRID_E_ARGUMENT (-1) /* null, not a number, out of its range, unknown body or hand */
#define STILLGRID_E_ORDER (-2)    /* not now: the line says what comes first */
#define STILLGRID_E_CAPACITY (-3) /* more than was declared, or than a segment has room for */
#define STILLGRID_E_SESSION (-4)  /* the session is taken, gone, or not ours to use */
#define STILLGRID_E_VERSION (-5)  /* the other side was built for another layout */
#define STILLGRID_E_THREAD (-6)   /* another thread is inside this handle */
#define STILLGRID_E_MEMORY (-7)
#define STILLGRID_E_FAULT (-8) /* ours: please report it with its line */

/* How a session counts time: CLOCK_MONOTONIC, or lockstep from 0, step by step with haptic_server
 * --lockstep. */
#define STILLGRID_REAL_TIME 0u
#define STILLGRID_VIRTUAL_TIME 1u

/* The newest version that the library knows, and its own as text, as "0.9.0". */
STILLGRID_API uint32_t stillgrid_api_version(void);
STILLGRID_API const char* stillgrid_library_version(void);

/* The line of this thread's last call that failed; empty before. Good until its next failure. */
STILLGRID_API const char* stillgrid_last_error(void);

/* ---- What is published once ---- */

typedef struct stillgrid_material {
  double stiffness_N_per_m; /* of a contact with the tool */
  double damping_N_s_per_m;
  double friction; /* Coulomb's */
} stillgrid_material;

/* Solid below: points with normal . x < offset_m are inside. */
typedef struct stillgrid_plane {
  double normal[3]; /* unit */
  double offset_m;
  uint32_t material;
  uint32_t body;
} stillgrid_plane;

/* Spheres by their arrays; positions_m has 3 values a sphere. */
typedef struct stillgrid_shapes {
  uint32_t struct_size;
  uint32_t count;
  const double* radii_m;     /* more than 0 */
  const uint32_t* materials; /* null: all of material 0 */
  const uint32_t* bodies;    /* null: all of body 0 */
  const double* positions_m; /* of static spheres; null for moving ones */
} stillgrid_shapes;

/* A hand: its tool, and where its device stands in the scene. */
typedef struct stillgrid_hand {
  uint32_t struct_size;
  uint32_t tool_count;  /* 1 at least */
  const char* name;     /* null: the only hand, without a name */
  const double* tool_m; /* 4 values a sphere of the tool: its centre in the tool's frame, radius */
  double device_position_m[3];
  double device_orientation_xyzw[4]; /* all 0: the scene's own axes */
  double device_scale;               /* metres in the scene a metre of the device; 0: 1 */
} stillgrid_hand;

typedef struct stillgrid_scene {
  uint32_t struct_size;
  uint32_t clock;           /* STILLGRID_REAL_TIME, STILLGRID_VIRTUAL_TIME */
  const char* session;      /* the name that haptic_server --session is given; null: "default" */
  const char* name;         /* shown to people; null: none */
  double period_s;          /* of publications; haptic_server fades the force when they stay away */
  uint32_t sphere_capacity; /* of moving spheres */
  uint32_t material_count;  /* 1 at least */
  uint32_t plane_count;
  uint32_t hand_count; /* 0: one hand, a ball of 5 mm, device at the origin */
  /* 1: set_responses() comes with each state, and haptic_server moves the touched bodies on from it
   * in each tick. 0: it may not, and the snapshots are shown by --transition linear, later by up to
   * a period. */
  uint32_t gives_inertia;
  uint32_t reserved;
  const stillgrid_material* materials;
  const stillgrid_plane* planes;
  const stillgrid_hand* hands;
  const stillgrid_shapes* static_shapes; /* null: none */
} stillgrid_scene;

/* ---- A publisher ---- */

typedef struct stillgrid_publisher stillgrid_publisher;

/* [main] Takes the session and announces an empty scene. Fails while another simulation has it. */
STILLGRID_API int stillgrid_publisher_open(const stillgrid_scene* scene,
                                           stillgrid_publisher** publisher);
/* [main] Ends the session: forces fade. Null does nothing. */
STILLGRID_API void stillgrid_publisher_close(stillgrid_publisher* publisher);

/* Waits for the next step, the one call that waits: in real time for the next period, in virtual
 * time until each hand's haptic_server has come as far; STILLGRID_AGAIN after 100 ms. time_ns: of
 * the state to publish next, on the scene's clock; the first call gives the start's.
 * STILLGRID_NOTHING: in virtual time, a haptic_server came to its end. A simulation in real time
 * that has a clock of its own need not call it. */
STILLGRID_API int stillgrid_publisher_wait(stillgrid_publisher* publisher, uint64_t* time_ns);

/* [step] Declares the moving spheres anew, in this order; a sphere whose radius, material or body
 * changes is one that came just now. */
STILLGRID_API int stillgrid_publisher_set_shapes(stillgrid_publisher* publisher,
                                                 const stillgrid_shapes* shapes);
/* [step] Their state: 3 values a sphere, in order. velocities_m_s may be null in a scene whose
 * spheres move by what their positions say. */
STILLGRID_API int stillgrid_publisher_set_spheres(stillgrid_publisher* publisher, uint32_t count,
                                                  const double* positions_m,
                                                  const double* velocities_m_s);

/* A rigid body at the state that was set, in the scene's frame: where its centre of mass is, how it
 * moves (m/s, rad/s: of the centre, and about it), and how it gives way: the acceleration (m/s2,
 * rad/s2) by a force at the centre and a torque (N, N m), row by row, symmetric, no eigenvalue
 * below 0. Joints belong into it, contacts as far as the engine knows them (docs/library.md). */
typedef struct stillgrid_response {
  uint32_t body;
  uint32_t reserved; /* 0 */
  double centre_m[3];
  double velocity[6];
  double inverse_inertia[36];
} stillgrid_response;

/* What a tool does to a body in a step: the mean over it. */
typedef struct stillgrid_push {
  uint32_t body;
  uint32_t contacts;
  double force_N[3];
  double point_m[3];    /* where the force acts */
  double torque_N_m[3]; /* beside that */
} stillgrid_push;

/* [step] The bodies of the state that was set, which give way to the tool; also those that it may
 * reach before the step after the next. Others go on at their spheres' velocities. */
STILLGRID_API int stillgrid_publisher_set_responses(stillgrid_publisher* publisher, uint32_t count,
                                                    const stillgrid_response* responses);
/* [step] What every hand's tool did to each moving body that it touched in the step that leads on
 * from the state that was set: the mean, tick by tick of 1 ms along the tool's recorded path, of
 * the contact law by which the force on the hand is computed. Call it when that time has passed,
 * after wait(): before the first publish() there are none. count: in, room for; out, how many there
 * are. Planes and static spheres are not told. step_s: of the engine; the next set_spheres() is the
 * state that it leads to. */
STILLGRID_API int stillgrid_publisher_pushes(stillgrid_publisher* publisher, double step_s,
                                             stillgrid_push* pushes, uint32_t* count);
/* [step] Shows all hands the state that was set as that of state_time_ns, as wait() gave it or of a
 * clock as the scene's; 0: now. */
STILLGRID_API int stillgrid_publisher_publish(stillgrid_publisher* publisher,
                                              uint64_t state_time_ns);

/* ---- A tool, and what was felt with it ---- */

/* One tick of a haptic_server. Forces and torques are those on the hand over the tick before. */
typedef struct stillgrid_tool {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t time_ns;
  uint64_t tick;
  double position_m[3];
  double orientation_xyzw[4];
  double velocity_m_s[3];
  double force_N[3];
  double torque_N_m[3];
  uint64_t buttons;
  double gripper_m; /* NaN where there is none, as axes */
  double axes[4];
  uint32_t contacts;
  uint32_t safety_flags; /* docs/safety.md */
  uint64_t missed_ticks; /* since it began */
  uint64_t work_ns;      /* of the tick; 0 in virtual time */
  uint64_t snapshot_id;  /* that was displayed; 0: none */
  double age_s;          /* of its state, when it was displayed */
} stillgrid_tool;

/* [step] The newest tick of hand number `hand`, in the scene's order. STILLGRID_NOTHING: no
 * haptic_server is there. */
STILLGRID_API int stillgrid_publisher_tool(stillgrid_publisher* publisher, uint32_t hand,
                                           stillgrid_tool* tool);

/* ---- A reader ---- */

typedef struct stillgrid_reader stillgrid_reader;

/* [main] Looks at a session, and at one hand of it (null: the only one), there or not yet: the
 * writers may come and go. */
STILLGRID_API int stillgrid_reader_open(const char* session, const char* hand,
                                        stillgrid_reader** reader);
STILLGRID_API void stillgrid_reader_close(stillgrid_reader* reader);

/* Who is there. */
typedef struct stillgrid_session_state {
  uint32_t struct_size;
  uint32_t clock;
  uint32_t is_published; /* its simulation lives */
  uint32_t is_felt;      /* so does its haptic_server */
  uint64_t scene_epoch;  /* random, of this run of the simulation; 0: none was seen */
  uint64_t tool_epoch;
  uint64_t publication_period_ns;
  uint64_t tick_period_ns;
  uint64_t snapshots; /* published */
  uint64_t ticks;
  uint32_t sphere_capacity;
  uint32_t static_count;
  uint32_t material_count;
  uint32_t plane_count;
  uint32_t tool_count;
  uint32_t reserved;
  char scene_name[64];
} stillgrid_session_state;

/* [main] Takes up what has come and drops what has gone, some 10 times a second or more often; what
 * a read gives is of the last poll's simulation and haptic_server, STILLGRID_NOTHING where they
 * were not there. Where one of the two cannot be read, the call says why, and has taken up the
 * other. */
STILLGRID_API int stillgrid_reader_poll(stillgrid_reader* reader, stillgrid_session_state* state);

/* What is published once; arrays of state's counts, null for what is not wanted:
 * STILLGRID_E_CAPACITY where one has no room for all. tool_m: as stillgrid_hand. */
typedef struct stillgrid_fixed {
  uint32_t struct_size;
  uint32_t material_capacity; /* room in the arrays */
  uint32_t plane_capacity;
  uint32_t tool_capacity;
  stillgrid_material* materials;
  stillgrid_plane* planes;
  double* tool_m;
  double device_position_m[3];
  double device_orientation_xyzw[4];
  double device_scale;
} stillgrid_fixed;
STILLGRID_API int stillgrid_reader_fixed(stillgrid_reader* reader, stillgrid_fixed* fixed);

/* A snapshot: capacity is the room in the arrays, null for what is not wanted. As many spheres as
 * fit are copied; count tells how many there are. A sphere that is not there has no number (NaN)
 * for a place. */
typedef struct stillgrid_snapshot {
  uint32_t struct_size;
  uint32_t capacity;
  uint32_t count;
  uint32_t contacts; /* in the simulation */
  uint64_t snapshot_id;
  uint64_t state_time_ns;
  uint64_t publish_time_ns;
  uint64_t tool_time_ns; /* of the tool in it; 0: none */
  uint64_t step_ns;      /* what its step cost */
  float* positions_m;    /* 3 values a sphere, as the one below */
  float* velocities_m_s;
  float* radii_m;
  uint32_t* materials; /* or STILLGRID_FIELD_POINT */
  uint32_t* bodies;
} stillgrid_snapshot;
/* As a sphere's material: a point of the surface of a body that the hand feels by its distance
 * field. No force comes from it. */
#define STILLGRID_FIELD_POINT 0xffffffffu
/* [step] The newest one, whole. STILLGRID_NOTHING: none yet, or overtaken at each attempt. */
STILLGRID_API int stillgrid_reader_snapshot(stillgrid_reader* reader, stillgrid_snapshot* snapshot);
/* [step] The static spheres; the times are 0. */
STILLGRID_API int stillgrid_reader_static(stillgrid_reader* reader, stillgrid_snapshot* snapshot);
/* [step] The same as snapshot(), but where the newest tick shows the spheres, between snapshots.
 * Velocities are NaN. STILLGRID_NOTHING also where the tick shows none of this simulation's last
 * two. */
STILLGRID_API int stillgrid_reader_displayed(stillgrid_reader* reader,
                                             stillgrid_snapshot* snapshot);
/* [step] */
STILLGRID_API int stillgrid_reader_tool(stillgrid_reader* reader, stillgrid_tool* tool);

/* ---- Spheres of a mesh ---- */

/* A closed surface: 3 values a vertex, 3 numbers of vertices a triangle. */
typedef struct stillgrid_mesh {
  uint32_t struct_size;
  uint32_t vertex_count;
  uint32_t triangle_count;
  uint32_t reserved;
  const double* vertices_m;
  const uint32_t* triangles;
} stillgrid_mesh;

/* What is asked of the spheres; one of them is not 0. */
typedef struct stillgrid_cover {
  uint32_t struct_size;
  uint32_t reserved;
  double tolerance_m;       /* few spheres, no farther from the surface */
  double surface_spacing_m; /* even spheres below the surface, so far apart */
  double volume_spacing_m;  /* even spheres throughout */
} stillgrid_cover;

typedef struct stillgrid_decomposition stillgrid_decomposition;

/* [main] Seconds, for a large mesh. What is certain to be wrong in it is repaired; an open one is
 * refused. A tolerance that cannot be reached is no error: the report tells what was. */
STILLGRID_API int stillgrid_decompose(const stillgrid_mesh* mesh, const stillgrid_cover* cover,
                                      stillgrid_decomposition** decomposition);
STILLGRID_API void stillgrid_decomposition_free(stillgrid_decomposition* decomposition);
STILLGRID_API uint32_t stillgrid_decomposition_count(const stillgrid_decomposition* decomposition);
/* 4 values a sphere, centre and radius; good until it is freed, as the report. Of null: null, 0. */
STILLGRID_API const double* stillgrid_decomposition_spheres(
    const stillgrid_decomposition* decomposition);
/* What sphere_decompose --report writes, as JSON, but for the names of files. */
STILLGRID_API const char* stillgrid_decomposition_report(
    const stillgrid_decomposition* decomposition);

#ifdef __cplusplus
}
#endif

#endif

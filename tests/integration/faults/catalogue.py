"""The faults of the table."""
import signal

import numpy

import daemons
from faults import shared_words
from faults.fault_run import Fault
from faults.injections import (after_trigger, fill_disk, kill_guardian, kill_hand_and_start_again, remove_recording, replace_sim,
                               signal_hand, signal_sim, signal_worker, spoil_scene, spoil_sphere, spoil_states,
                               spoil_stopped_scene, stop_and_go, stop_both, stop_hand, stop_sim,
                               trigger, truncate, unlink)

_SCENE = """format = 2
[world]
gravity_m_s2 = [0.0, 0.0, 0.0]
[simulation]
rate_hz = 30.0
[tool]
radius_m = 0.005
[[material]]
name = "material"
contact_stiffness_N_per_m = {stiffness_N_per_m}
[[body]]
name = "body"
material = "material"
"""
BALL = ("ball.toml", _SCENE.format(stiffness_N_per_m=1000.0) + """kind = "sphere"
motion = "prescribed"
velocity_m_s = [0.0, 0.0, 0.0]
position_m = [0.0, 0.0, -0.05]
radius_m = 0.05
""")
# Pinned below and held up by its springs: it gives way to the tool.
BLOCK = ("block.toml", _SCENE.format(stiffness_N_per_m=1000.0) + """kind = "soft_block"
nodes = [2, 2, 2]
size_m = [0.1, 0.1, 0.1]
position_m = [0.0, 0.0, -0.05]
mass_kg = 0.4
spring_stiffness_N_per_m = { structural = 2000.0, shear = 500.0, bend = 500.0 }
spring_damping_N_s_per_m = 5.0
spheres = { spacing_m = 0.1, radius_m = 0.05 }
pinned = [0, 1, 2, 3]
""")
STIFF_WALL = ("stiff_wall.toml", _SCENE.format(stiffness_N_per_m=1e5) + """kind = "plane"
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
""")

BLOCK_N = 1.8088  # on a tool held as the driver's

# Until there is no force, ms, on a machine that grants every tick.
AT_ONCE = 5.0
FADE = 101.0  # and the tick that notices
PERIOD = 100.0 / 3.0  # of the simulation
STALE = 1.5 * PERIOD
GOES_ON = 1000.0  # that haptic_server simulates alone
LOCK_IS_FREE = 10.0  # as a poll finds
LAST_STAMP = 100.0  # that a device's stamp may be old
WATCHDOG = 111.0  # without a tick, and its polls
STOP_HANGS = WATCHDOG + 300.0 + 150.0  # that is waited for; and for the one of the release
RELEASE = 50.0  # by a process that opens the device anew
CRASH_HANGS = 100.0 + 100.0 + RELEASE
PARENT_IS_GONE = 10.0  # as the watchdog's poll finds
SILENCE = 2000.0 + RELEASE  # of the process that holds the device
CUT_IS_LATE = 100.0
RELEASE_IS_LATE = 2000.0  # by processes and threads that end, begin and have no priority

HOLD, LINEAR = ("--transition", "hold"), ("--transition", "linear")  # show the spheres of snapshots, while they come

WITH_FADE = {"zero_ms": FADE, "flag": "bad_device", "is_smooth": True}
CUT = {"zero_ms": AT_ONCE, "is_cut": True, "late_ms": CUT_IS_LATE}
ENDS_AT_ONCE = {**CUT, "after_N": None}
DEVICE_FAULT = {**ENDS_AT_ONCE, "status": daemons.DEVICE_FAULT}
STOPPED = {**CUT, "zero_ms": WATCHDOG}
STOPPED_FOR_GOOD = {**DEVICE_FAULT, "zero_ms": WATCHDOG}
STALE_SNAPSHOT = {"zero_ms": STALE + FADE, "flag": "faded", "is_smooth": True}
DEAD_WRITER = {**STALE_SNAPSHOT, "zero_ms": LOCK_IS_FREE + FADE, "late_ms": STALE - LOCK_IS_FREE}
ENDED = {"zero_ms": FADE, "after_N": None, "is_smooth": True}
FREE_BEFORE = {"full_N": 0.0, "may_be_zero": True}
PRESS = "fault=moves,z_m=0.006,speed_m_s=0.05"

DEVICE = [
    Fault("device", "position is NaN for 0.3 s", "fault=position_nan,for_s=0.3", **WITH_FADE),
    Fault("device", "position is infinite for 0.3 s", "fault=position_infinite,for_s=0.3",
          **WITH_FADE),
    Fault("device", "position is 1e9 m away for 0.3 s", "fault=position_huge,for_s=0.3",
          **WITH_FADE),
    Fault("device", "no position for 0.3 s", "fault=position_missing,for_s=0.3", **WITH_FADE),
    Fault("device", "orientation is NaN for 0.3 s", "fault=orientation_nan,for_s=0.3",
          **{**WITH_FADE, "flag": "no_orientation"}),
    Fault("device", "1 m deeper in one tick", "fault=leaps,for_s=0.0005", flag="bad_device",
          is_smooth=True),
    Fault("device", "1 m deeper for good", "fault=leaps", after_N=3.3, may_be_zero=True,
          flag="leap"),
    Fault("device", "position flickers by 2 mm each tick", "fault=flickers,for_s=0.3",
          flag="slewed"),
    Fault("device", "stamps go back for 0.3 s", "fault=stamps_back,for_s=0.3", **WITH_FADE),
    Fault("device", "stamps stand still for 0.4 s", "fault=stamps_frozen,for_s=0.4",
          zero_ms=LAST_STAMP + FADE, flag="bad_device", is_smooth=True),
    Fault("device", "pose stands still under fresh stamps for 0.4 s",
          "fault=sequence_frozen,for_s=0.4", zero_ms=LAST_STAMP + FADE, flag="frozen",
          is_smooth=True),
    Fault("device", "stamps 1 s ahead for 0.3 s", "fault=stamps_ahead,for_s=0.3", **WITH_FADE),
    Fault("device", "read fails", "fault=read_fails", says="the cable is out", **DEVICE_FAULT),
    Fault("device", "cable out for 0.4 s, opened again", "fault=read_fails,for_s=0.4",
          haptic=("--reopen", "3"), zero_ms=AT_ONCE, is_cut=True, says="open again, at try 1 of 3"),
    Fault("device", "cable out for good, opened twice", "fault=read_fails", haptic=("--reopen", "2"),
          **{**DEVICE_FAULT, "says": "no further try of 2", "ends_after_s": 10.0}),
    Fault("device", "write fails", "fault=write_fails", says="the cable is out", **DEVICE_FAULT),
    Fault("device", "read throws", "fault=read_throws", **DEVICE_FAULT),
    Fault("device", "write throws", "fault=write_throws", **DEVICE_FAULT),
    Fault("device", "read writes past its struct", "fault=oversteps", **DEVICE_FAULT),
    Fault("device", "read hangs for 0.4 s", "fault=read_hangs", says="the device was stopped",
          **STOPPED),
    Fault("device", "write hangs for 0.4 s", "fault=write_hangs", says="the device was stopped",
          **STOPPED),
    Fault("device", "read hangs for 0.4 s, three times", "fault=read_hangs_again",
          says="stopped 3 times", **STOPPED_FOR_GOOD),
    Fault("device", "read hangs, and no motors after", "fault=read_hangs_and_dies",
          says="the device is gone", **STOPPED_FOR_GOOD),
    Fault("device", "read hangs for ever", "fault=read_hangs_for_ever",
          says="did not return in time", **STOPPED_FOR_GOOD),
    Fault("device", "each read takes 5 ms for 0.5 s", "fault=read_slow,for_s=0.5"),
    Fault("device", "its motors are off for 0.4 s", "fault=motors_off,for_s=0.4",
          says="its motors are off", flag="motors_off", **CUT),
    Fault("device", "it tells hot motors for 0.4 s", "fault=gets_hot,for_s=0.4",
          says="its motors are too hot", flag="hot", **CUT),
    Fault("device", "the recording ends", "fault=read_ends", **ENDS_AT_ONCE),
    Fault("device", "carried off at 3 m/s", "fault=moves,z_m=-0.5,speed_m_s=3,max_speed_m_s=1",
          full_N=3.3, zero_ms=60.0, flag="speed"),  # the estimate, the slew limit
    Fault("device", "leaves its workspace",
          "fault=moves,to_x_m=0.06,speed_m_s=0.3,workspace_m=0.05", zero_ms=50.0 / 0.3 + 2.0,
          after_N=0.0, flag="workspace"),
]

RELEASED = {**DEVICE_FAULT, "zero_ms": RELEASE, "late_ms": RELEASE_IS_LATE,
            "leaves_report": False}
BY_GUARDIAN = "its motors were released"
GIVEN_UP = {**DEVICE_FAULT, "zero_ms": STOP_HANGS, "late_ms": RELEASE_IS_LATE,
            "says": BY_GUARDIAN}
LEFT_ON = {**DEVICE_FAULT, "says": BY_GUARDIAN}


def crashed(number):
    return {**ENDS_AT_ONCE, "status": 128 + number, "leaves_report": False, "says": BY_GUARDIAN}


def leaving(call):
    """A driver that ends its program in a call of the loop."""
    return [
        Fault("driver", f"{call} calls exit", f"fault={call}_exits",
              **{**LEFT_ON, "says": "a call ended the program"}),
        Fault("driver", f"{call} calls _exit", f"fault={call}_exits_at_once", **RELEASED,
              says="a call ended its process, with exit status 0"),
        Fault("driver", f"{call} calls pthread_exit", f"fault={call}_ends_its_thread",
              **crashed(signal.SIGABRT)),
        Fault("driver", f"{call} aborts", f"fault={call}_aborts", **crashed(signal.SIGABRT)),
        Fault("driver", f"{call} crashes", f"fault={call}_crashes", **crashed(signal.SIGSEGV)),
    ]


# Two faults at a time, the second where the first is to be mended.
DRIVER = leaving("read") + leaving("write") + [
    Fault("driver", "read hangs for ever, emergency_stop too",
          "fault=read_hangs_for_ever+emergency_stop_hangs_for_ever", **GIVEN_UP),
    Fault("driver", "read hangs for 0.4 s, emergency_stop for ever",
          "fault=read_hangs+emergency_stop_hangs_for_ever", **GIVEN_UP),
    Fault("driver", "read fails, emergency_stop hangs for ever",
          "fault=read_fails+emergency_stop_hangs_for_ever", **GIVEN_UP),
    Fault("driver", "read fails, emergency_stop calls exit",
          "fault=read_fails+emergency_stop_exits", **{**RELEASED, "says": BY_GUARDIAN}),
    Fault("driver", "read fails, emergency_stop calls _exit",
          "fault=read_fails+emergency_stop_exits_at_once", **{**RELEASED, "says": BY_GUARDIAN}),
    Fault("driver", "read fails, emergency_stop crashes",
          "fault=read_fails+emergency_stop_crashes",
          **{**crashed(signal.SIGSEGV), "zero_ms": CRASH_HANGS, "late_ms": RELEASE_IS_LATE}),
    Fault("driver", "read crashes, emergency_stop hangs for ever",
          "fault=read_crashes+emergency_stop_hangs_for_ever",
          **{**RELEASED, "says": "crashed, hung and was killed", "zero_ms": CRASH_HANGS}),
    Fault("driver", "the recording ends, emergency_stop hangs for ever",
          "fault=read_ends+emergency_stop_hangs_for_ever", **GIVEN_UP),
    Fault("driver", "the recording ends, deactivate fails", "fault=read_ends+deactivate_fails",
          **{**LEFT_ON, "says": "deactivate: the cable is out"}),
    Fault("driver", "the recording ends, deactivate throws", "fault=read_ends+deactivate_throws",
          **LEFT_ON),
    Fault("driver", "the recording ends, deactivate hangs for ever",
          "fault=read_ends+deactivate_hangs_for_ever", **{**LEFT_ON, "ends_after_s": 40.0}),
    Fault("driver", "the recording ends, deactivate calls _exit",
          "fault=read_ends+deactivate_exits_at_once", **{**LEFT_ON, "leaves_report": False}),
    Fault("driver", "the recording ends, deactivate crashes",
          "fault=read_ends+deactivate_crashes", **crashed(signal.SIGSEGV)),
    Fault("driver", "read forks, and its parent calls _exit", "fault=read_forks", inject=trigger,
          **{**RELEASED, "says": "processes that its driver had left were killed"}),
]

SIMULATION = [
    Fault("simulation", "killed", inject=signal_sim(signal.SIGKILL), after_N=0.0, **DEAD_WRITER),
    Fault("simulation", "Ctrl-C", inject=signal_sim(signal.SIGINT), after_N=0.0,
          **{**DEAD_WRITER, "zero_ms": PERIOD + LOCK_IS_FREE + FADE}),
    Fault("simulation", "stopped for 0.4 s", inject=stop_sim(0.4), is_smooth=True),
    Fault("simulation", "stopped for 1.4 s", inject=stop_sim(1.4), **{**STALE_SNAPSHOT, "zero_ms": GOES_ON + FADE}),
    Fault("simulation", "stopped for 0.4 s, by linear", haptic=LINEAR, inject=stop_sim(0.4), **STALE_SNAPSHOT),
    Fault("simulation", "stops for 80 ms, four times, by linear", haptic=LINEAR, inject=stop_and_go, flag="faded",
          is_smooth=True),
    Fault("simulation", "killed, replaced at once", inject=replace_sim("wall"), **DEAD_WRITER),
    Fault("simulation", "killed, replaced by another scene", inject=replace_sim(BALL),
          **DEAD_WRITER),
    Fault("simulation", "killed, the next comes 0.5 s later", inject=replace_sim("wall", 0.5),
          **DEAD_WRITER),
]

MEMORY = [
    Fault("memory", "sphere's place is NaN", scene=BALL, haptic=HOLD,
          inject=spoil_sphere(0, 3, float("nan")), zero_ms=FADE),
    Fault("memory", "sphere's place is 1e30 m", scene=BALL, haptic=HOLD, inject=spoil_sphere(0, 3, 1e30),
          zero_ms=FADE),
    Fault("memory", "sphere's radius is 1e30 m", scene=BALL, haptic=HOLD,
          inject=spoil_sphere(shared_words.RADIUS, 1, 1e30), zero_ms=FADE),
    Fault("memory", "sphere's radius is NaN", scene=BALL, haptic=HOLD,
          inject=spoil_sphere(shared_words.RADIUS, 1, float("nan")), zero_ms=FADE),
    Fault("memory", "sphere's motion is 1e30 m/s", scene=BALL, haptic=HOLD, inject=spoil_sphere(12, 3, 1e30),
          may_be_zero=True),
    *(Fault("memory", f"{what} of a block that gives way", scene=BLOCK, inject=inject,
            full_N=BLOCK_N, after_N=BLOCK_N, may_be_zero=True)
      for what, inject in (
          ("the state is 0xFF throughout", spoil_states),
          ("the state has 2^60 bytes",
           spoil_scene(shared_words.PAYLOAD + shared_words.STATE_BYTES, "u8", 1, 1 << 60)),
          ("the state is of tick 2^60",
           spoil_scene(shared_words.PAYLOAD + shared_words.STATE_TICK, "u8", 1, 1 << 60)),
          ("the state's hash is 7",
           spoil_scene(shared_words.PAYLOAD + shared_words.STATE_HASH, "u8", 1, 7)))),
    Fault("memory", "number of the newest slot is 2^60", scene=BALL,
          inject=spoil_scene(shared_words.LATEST, "u8", 1, 1 << 60, False), may_be_zero=True,
          is_smooth=True),
    Fault("memory", "number of the newest slot is 0", scene=BALL,
          inject=spoil_scene(shared_words.LATEST, "u8", 1, 0, False), may_be_zero=True,
          is_smooth=True),
    Fault("memory", "a snapshot is 0xFF throughout", scene=BALL,
          inject=spoil_scene(shared_words.PAYLOAD, "u1", 600, 0xFF), may_be_zero=True),
    Fault("memory", "a snapshot is random bytes", scene=BALL,
          inject=spoil_scene(shared_words.PAYLOAD, "u1", 2048,
                             numpy.random.default_rng(2002).integers(0, 256, 2048, "u1")),
          may_be_zero=True),
    Fault("memory", "sequences of both slots are odd",
          inject=spoil_scene(shared_words.SEQUENCE, "u8", 1, 7), may_be_zero=True, is_smooth=True),
    Fault("memory", "a material is NaN",
          inject=spoil_scene(shared_words.MATERIALS, "f4", 4, float("nan"), False)),
    Fault("memory", "stopped, the snapshot's stamps 60 s ahead", haptic=LINEAR, inject=spoil_stopped_scene,
          **STALE_SNAPSHOT),
    Fault("memory", "scene cut off to 0 bytes", inject=truncate("scene"), after_N=0.0,
          says="was shrunk", **DEAD_WRITER),
    Fault("memory", "scene's name removed", inject=unlink("scene")),
    Fault("memory", "tool's segment cut off to 0 bytes", inject=truncate("tool"),
          says="was shrunk", status=daemons.COULD_NOT_START, **ENDS_AT_ONCE),
]

CLOCK = [
    Fault("clock", "haptic_server stopped for 0.4 s, goes on", inject=stop_hand, flag="stalled",
          **CUT),
    Fault("clock", "both stopped for 0.4 s, go on", inject=stop_both, flag="stalled", **CUT),
]

OTHERS = [
    Fault("disk", "recording's disk is full", inject=fill_disk, says="could not be written",
          status=daemons.INCOMPLETE),
    Fault("disk", "recording is removed", inject=remove_recording),
    Fault("operator", "Ctrl-C", inject=signal_hand(signal.SIGINT), **ENDED),
    Fault("operator", "SIGTERM", inject=signal_hand(signal.SIGTERM), **ENDED),
    Fault("operator", "terminal closed", inject=signal_hand(signal.SIGHUP), **ENDED),
    Fault("operator", "haptic_server killed, started again", inject=kill_hand_and_start_again,
          may_be_zero=True, is_cut=True),
    Fault("force", "contact of 1e5 N/m, device for 1000", PRESS + ",stiffness_N_per_m=1000",
          scene=STIFF_WALL, flag="stiffness", **FREE_BEFORE),
    Fault("force", "pressed above the continuous force of 1 N",
          PRESS + ",continuous_force_N=1,motor_time_constant_s=0.2", after_N=1.0, flag="budget",
          **FREE_BEFORE),
    Fault("force", "pressed 50 mm deep, 50 N", PRESS + ",to_z_m=-0.045", after_N=3.3,
          flag="clamped", **FREE_BEFORE),
]

SIGNALS = [
    *(Fault("signal", f"{number.name} to the loop", inject=signal_worker(number),
            **crashed(number))
      for number in (signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT,
                     signal.SIGTRAP, signal.SIGSYS)),
    Fault("signal", "SIGKILL to the loop", inject=signal_worker(signal.SIGKILL),
          **{**crashed(signal.SIGKILL), "zero_ms": RELEASE, "late_ms": RELEASE_IS_LATE}),
    Fault("signal", "SIGSTOP to the loop, for ever", inject=signal_worker(signal.SIGSTOP),
          **{**RELEASED, "zero_ms": SILENCE, "says": "stood still for 2 s and was killed"}),
    *(Fault("signal", name, inject=signal_hand(number), **ENDED, status=128 + number,
            says="ended by signal")
      for name, number in (("SIGQUIT", signal.SIGQUIT), ("SIGUSR1", signal.SIGUSR1),
                           ("SIGALRM", signal.SIGALRM), ("SIGXCPU", signal.SIGXCPU),
                           ("SIGRTMIN", signal.SIGRTMIN))),
    *(Fault("signal", f"{number.name} to the guardian", inject=signal_hand(number), **ENDED,
            status=-number)
      for number in (signal.SIGSEGV, signal.SIGABRT)),
    Fault("signal", "SIGKILL to the guardian", inject=kill_guardian, **ENDED,
          status=-signal.SIGKILL),
    *(Fault("signal", f"{number.name}, whose handler the driver has replaced",
            "fault=read_takes_signals", inject=after_trigger(signal_hand(number)), **ENDED)
      for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)),
    Fault("signal", "SIGKILL to the guardian, SIGTERM's handler replaced",
          "fault=read_takes_signals", inject=after_trigger(kill_guardian),
          **{**ENDED, "zero_ms": FADE + PARENT_IS_GONE}, status=-signal.SIGKILL),
]

FAULTS = DEVICE + DRIVER + SIMULATION + MEMORY + CLOCK + OTHERS + SIGNALS

#!/usr/bin/python3
"""A fake of the Haply Inverse Service: its messages on a WebSocket, a simulated device and hand, and faults.

Frames: docs.haply.co (inverseSDK/service/realtime/websocket-protocol and control-commands, 3.5), the real ones
in the comments of InfinyTech3D/SofaHaplyRobotics (3.4.8), IsaacLab's se3_haply.py (3.1, wireless grip). A
message of the client's is answered by exactly one, beside the inventory at the start. Prints its port. Each
force that it received is a line of --log: time_s fx fy fz, of whatever spelling it takes.
"""
import argparse
import asyncio
import json
import math
import os
import signal
import time

import websockets

FAULTS = ("slow", "garbage", "silent", "dies", "wrong_echo", "unplugged", "huge", "wrong_type", "nan", "nested",
          "no_echo", "moved", "twice", "uncalibrated", "unpowered", "grip_gone")
SPELLINGS = {"3.1": ("values",), "3.4": ("values",), "3.5": ("values", "vector"), "vector_only": ("vector",),
             "none": ()}
STEP_S = 1e-4


class Arm:
    """A mass that a hand holds by a spring and pushes down and up: 60 mm in 2 s."""
    MASS_KG, DAMPING_N_S_PER_M, HAND_N_PER_M, HAND_N_S_PER_M = 0.25, 0.5, 150.0, 3.0

    def __init__(self, name):
        self.name = name
        self.position_m, self.velocity_m_s = [0.0, 0.0, 0.03], [0.0, 0.0, 0.0]
        self.force_N = [0.0, 0.0, 0.0]
        self.began_s = self.now_s = time.monotonic()

    def advance(self):
        """To now; what a stall takes beyond 20 ms is skipped."""
        now_s = time.monotonic()
        self.now_s = max(self.now_s, now_s - 0.02)
        while self.now_s + STEP_S <= now_s:
            self.now_s += STEP_S
            hand_m = (0.0, 0.0, 0.03 * math.cos(math.pi * (self.now_s - self.began_s)))
            for axis in range(3):
                total_N = (self.force_N[axis] + self.HAND_N_PER_M * (hand_m[axis] - self.position_m[axis])
                           - (self.DAMPING_N_S_PER_M + self.HAND_N_S_PER_M) * self.velocity_m_s[axis])
                self.velocity_m_s[axis] += STEP_S * total_N / self.MASS_KG
                self.position_m[axis] += STEP_S * self.velocity_m_s[axis]


def vector(x, y, z):
    return {"x": x, "y": y, "z": z}


PLACED = {"position": vector(0, 0, 0), "rotation": {"w": 1, **vector(0, 0, 0)}, "scale": vector(1, 1, 1)}


class Service:
    def __init__(self, options):
        self.options = options
        self.arms = [Arm(name) for name in ("049D", "04EA")[:options.devices]]
        self.grips = [f"6157{n}" for n in range(options.grips)]
        self.log = open(options.log, "w") if options.log else None
        self.replies = 0
        self.sessions = self.open_sessions = 0

    def config_of(self):
        """As 3.4 has it, and what came with 3.5."""
        config = {"type": "inverse3", "port": "COM12", "handedness": "right", "streaming_mode": "USB",
                  "device_info": {"major_version": 7, "minor_version": 4, "id": "049D", "device_type": 4},
                  "gravity_compensation": {"enabled": True, "scaling_factor": 1.0},
                  "torque_scaling": {"enabled": True}}
        if self.options.version == "3.5":
            config.update({"preset": "defaults", "basis": {"permutation": "XYZ"}, "mount": PLACED,
                           "extended_firmware_version": "7.4.0-a1b2", "home_return": {"enabled": False},
                           "filters": {"force_gate": {"gain": 0.3}, "damping": {"scalar": 0.0}}})
        if self.options.frame == "basis":
            config["basis"] = {"permutation": "XZY"}
        return config

    def state_of(self, arm, is_faulty):
        shown_N = [2 * force for force in arm.force_N] if is_faulty("wrong_echo") else arm.force_N
        zero = {"a0": 0, "a1": 0, "a2": 0}
        state = {"angular_position": {"a0": -30.927332, "a1": 53.878685, "a2": -6.642623},
                 "angular_velocity": zero, "current_angular_position": zero, "current_angular_torques": zero,
                 "body_orientation": {"w": 0.69885254, "x": 0.0014648438, "y": 0.715271, "z": 0.0024414062},
                 "control_domain": "cartesian", "control_mode": "force", "mode": "force",
                 "current_cursor_force": vector(*shown_N), "current_cursor_position": vector(0, 0, 0),
                 "cursor_position": vector(*arm.position_m), "cursor_velocity": vector(*arm.velocity_m_s),
                 "transform": PLACED}
        if is_faulty("no_echo"):
            del state["current_cursor_force"]
        if is_faulty("wrong_type"):
            state["cursor_position"]["z"] = "0.03"
        if is_faulty("moved"):
            state["transform"] = {**PLACED, "scale": vector(2, 2, 2)}
        return state

    def message(self, is_inventory):
        def is_faulty(fault):
            return self.options.fault == fault and self.replies > self.options.after
        listed = [] if is_faulty("unplugged") else self.arms
        devices = [{"device_id": arm.name, "state": self.state_of(arm, is_faulty),
                    "status": {"calibrated": not is_faulty("uncalibrated"), "in_use": True, "ready": True,
                               "power_supply": not is_faulty("unpowered"), "started": True}} for arm in listed]
        turn_rad = time.monotonic() % math.tau
        state = {"orientation": {"w": math.cos(turn_rad / 2), **vector(0, 0, math.sin(turn_rad / 2))},
                 "transform": PLACED}
        if self.options.grip == "verse_grip":
            state.update({"button": True, "hall": 1})
        else:
            state.update({"buttons": {"a": False, "b": True, "c": False}, "hall": 1, "battery_level": 0.75})
        grips = [] if is_faulty("grip_gone") else [{"device_id": name, "state": state} for name in self.grips]
        message = {"inverse3": devices, self.options.grip: grips}
        if is_inventory:
            message["session_id"] = self.sessions
            for device in devices:
                device["config"] = self.config_of()
        text = json.dumps(message)
        if is_faulty("garbage"):
            return "\x00 no JSON {"
        if is_faulty("nan"):
            return text.replace('"cursor_position": {"x": ', '"cursor_position": {"x": NaN, "was": ')
        if is_faulty("nested"):
            return '{"inverse3":' + "[" * 20000 + "]" * 20000 + "}"
        if is_faulty("huge"):
            return json.dumps({**message, "more": "x" * 100_000})
        return text

    def obey(self, text):
        for device in json.loads(text).get("inverse3", []):
            command = device.get("commands", {}).get("set_cursor_force", {})
            for arm in self.arms:
                if arm.name != device.get("device_id"):
                    continue
                told = [command[name] for name in SPELLINGS[self.options.version] if name in command]
                arm.force_N = [float(told[0][axis]) for axis in "xyz"] if told else [0.0, 0.0, 0.0]
                sent = next(iter(command.values()), vector(0, 0, 0))
                if self.log:
                    print(f"{time.monotonic():.6f}", *(sent[axis] for axis in "xyz"), arm.name, file=self.log)

    async def serve(self, socket):
        self.sessions += 1
        self.open_sessions += 1
        try:
            await socket.send(self.message(is_inventory=True))
            async for text in socket:
                for arm in self.arms:
                    arm.advance()
                self.obey(text)
                self.replies += 1
                is_due = self.replies > self.options.after
                if self.options.fault == "slow" and is_due:
                    await asyncio.sleep(0.03)
                if self.options.fault == "dies" and is_due:
                    self.log.flush()
                    os._exit(0)
                if self.options.fault == "silent" and is_due:
                    continue
                await socket.send(self.message(is_inventory=False))
                if self.options.fault == "twice" and is_due:
                    await socket.send(self.message(is_inventory=False))
        except websockets.ConnectionClosed:
            pass
        finally:
            self.open_sessions -= 1
            for arm in self.arms:
                arm.force_N = [0.0, 0.0, 0.0]  # a session takes its forces along
            if self.log:
                self.log.flush()


async def run(options):
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))  # as the real one, not behind compilers
    except PermissionError:
        pass
    service = Service(options)
    is_over = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, is_over.set)
    async with websockets.serve(service.serve, "127.0.0.1", options.port, compression=None) as server:
        print(server.sockets[0].getsockname()[1], flush=True)
        await is_over.wait()
        for _ in range(500):  # what was sent before is read, to the end of each connection
            if service.open_sessions == 0:
                break
            await asyncio.sleep(0.01)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, default=0, help="default: one that is free")
    parser.add_argument("--version", choices=SPELLINGS, default="3.5")
    parser.add_argument("--fault", choices=("none", *FAULTS), default="none")
    parser.add_argument("--after", type=int, default=0, metavar="N", help="replies that are right")
    parser.add_argument("--devices", type=int, default=1)
    parser.add_argument("--grips", type=int, default=1)
    parser.add_argument("--grip", default="wireless_verse_grip", help="the name of their list")
    parser.add_argument("--frame", choices=("own", "basis"), default="own")
    parser.add_argument("--log")
    asyncio.run(run(parser.parse_args()))


if __name__ == "__main__":
    main()

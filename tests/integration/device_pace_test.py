#!/usr/bin/python3
"""A device may set the pace, be lost and come back, be given orders and have a gripper."""
import json
import os
import subprocess
import unittest
import unittest.mock

import daemons
import stiffest_wall
from daemons import BUILD

SCENE = "tissue_and_blocks"
HOSTILE = BUILD / "tests" / "shared" / "tools" / "hostile_drivers" / "hostile.so"
HAND = "phantom:profile=premium15,hand=light,path=press,centre_z_m=0,depth_m=0.06,period_s=1"


class DevicePaceTest(daemons.SessionTest):
    def run_in_real_time(self, device, *options, duration_s=1.0):
        """The report, the recording and the lines of a run beside a simulation."""
        record, report = self.folder / "run.csv", self.folder / "run.json"
        self.sim_server(SCENE)
        server = self.haptic_server(device, "--duration", duration_s, "--record", record, "--report", report,
                                    *options)
        self.assertEqual(server.wait(20.0), daemons.DONE, server.lines())
        return daemons.read_report(report), daemons.read_recording(record), server.lines()

    def test_a_tick_of_delay_costs_two_thirds_of_the_stiffness_and_a_device_that_sets_the_pace_has_none(self):
        limits = {pace: stiffest_wall.limit_N_per_m(BUILD, pace) for pace in stiffest_wall.PACES}
        self.assertEqual(limits["device"], limits["host"])
        # 2 b/T and 2 b/(3 T) of a device with b = 5 N s/m, T = 1 ms; the bisection's step is 3.5 %.
        self.assertAlmostEqual(limits["host"], 10000.0, delta=600.0)
        self.assertAlmostEqual(limits["late"], 10000.0 / 3.0, delta=200.0)

    def test_a_device_ticks_the_loop_from_its_own_thread(self):
        report, recording, lines = self.run_in_real_time(HAND + ",pace=device")
        self.assertEqual(lines, [])
        self.assertTrue(report["declared"]["sets_pace"])
        self.assertEqual(report["device_stops"], 0)
        self.assertGreater(report["ticks"], 500)
        self.assertEqual(len(recording["z_m"]), report["ticks"] - report["lost_rows"])
        self.assertGreater(recording["contacts"].max(), 0)

    def test_a_stopped_process_at_the_devices_pace_goes_on_without_a_blow(self):
        report = self.folder / "run.json"
        self.sim_server(SCENE)
        server = self.haptic_server(HAND + ",pace=device", "--duration", 2.0, "--report", report)
        self.wait_until(lambda: list(daemons.SHM.glob(f"{self.session}-tool")), 5.0, "no tool")
        server.signal(daemons.signal.SIGSTOP)
        daemons.time.sleep(0.4)
        server.signal(daemons.signal.SIGCONT)
        self.assertEqual(server.wait(20.0), daemons.DONE, server.lines())
        self.assertLessEqual(daemons.read_report(report)["force_N"]["max"], 8.5)

    def test_a_device_that_ticks_at_another_rate_or_never_is_told(self):
        self.sim_server(SCENE)
        for mode, status, line in (("ticks_seldom", daemons.DONE, " Hz; expected 1000 Hz"),
                                   ("no_ticks", daemons.DEVICE_FAULT, "stopped 3 times for want of ticks")):
            with self.subTest(mode):
                report = self.folder / f"{mode}.json"
                with unittest.mock.patch.dict(os.environ, {"STILLGRID_HOSTILE_FAULT": mode}):
                    server = self.haptic_server(HOSTILE, "--duration", 3.5, "--report", report)
                self.assertEqual(server.wait(20.0), status, server.lines())
                self.assertIn(line, "\n".join(server.lines()))
                self.assertIn("ticks", daemons.read_report(report))

    def test_in_virtual_time_the_host_sets_the_pace(self):
        paces = [self.run_lockstep(SCENE, f"phantom:pace={pace}", 0.3).read_bytes() for pace in ("host", "device")]
        self.assertEqual(paces[0], paces[1])

    def test_orders_reach_an_active_device_and_refusals_are_lines(self):
        orders = self.write("orders", "push_z_N=-1.5\nno such order=1\nnonsense\npush_x_N=much\npush_y_N=1e308\ngrip_N=-1\n"
                            "buttons=4\ntool.clutch=yes\ntool.scale=0.5\n")
        _, _, lines = self.run_in_real_time("phantom:path=still,hand=light", "--commands", orders)
        text = "\n".join(lines)
        self.assertIn("command push_z_N=-1.5", text)
        self.assertIn("command 'no such order=1': no such order: value '1': expected a known key", text)
        self.assertIn("command 'nonsense': expected KEY=VALUE", text)
        self.assertIn("command 'push_x_N=much': push_x_N: value 'much': expected a finite number", text)
        self.assertIn("push_y_N: value '1e308': expected -50 to 50", text)
        self.assertIn("grip_N: value '-1': expected 0 to 50", text)
        self.assertIn("command 'buttons=4': buttons: value '4': expected 0 to 3", text)
        self.assertIn("command 'tool.clutch=yes': value 'yes': expected on or off", text)
        self.assertIn("command tool.scale=0.5", text)
        self.assertEqual(len([line for line in lines if ": command " in line]), 9, lines)

    def test_the_last_order_of_a_file_needs_no_end_of_line_and_a_flood_is_summed(self):
        orders = self.write("orders", "nonsense\n" * 1000 + "push_z_N=-1.5")
        _, _, lines = self.run_in_real_time("phantom:path=still,hand=light", "--commands", orders)
        self.assertIn("command push_z_N=-1.5", "\n".join(lines))
        self.assertEqual(len([line for line in lines if "'nonsense'" in line]), 20)
        self.assertIn("1000 commands were refused, 980 of them not told", "\n".join(lines))

    def test_what_a_pipes_writer_left_unfinished_is_no_part_of_the_next_ones_order(self):
        pipe = self.folder / "orders"
        os.mkfifo(pipe)
        self.sim_server(SCENE)
        server = self.haptic_server("phantom:path=still,hand=none", "--commands", pipe)
        for text, line in (("push_x", "command 'push_x': its writer left"), ("push_z_N=-1\n", "command push_z_N=-1")):
            pipe.write_text(text)
            self.wait_until(lambda: line in "\n".join(server.lines()), 10.0, line)
        self.assertEqual(server.stop(), daemons.DONE, server.lines())

    def test_a_folder_gives_no_orders(self):
        self.sim_server(SCENE)
        for folder in (self.folder, ""):
            server = self.haptic_server("phantom", "--commands", folder)
            self.assert_refused(server, daemons.BAD_INPUT, "--commands", "expected a file")

    def test_a_list_ends_with_a_line_and_a_status_whatever_the_driver_does(self):
        for device, status, line in (("phantom@1", 3, "there are devices @0 to @0"),
                                     ("nosuch", 1, "expected a path to a .so")):
            with self.subTest(device):
                listed = subprocess.run([BUILD / "bin" / "haptic_server", "--list-devices", "--device", device],
                                        capture_output=True, text=True)
                self.assertEqual((listed.returncode, listed.stdout), (status, ""), listed.stderr)
                self.assertIn(line, listed.stderr)
                self.assertEqual(listed.stderr.count("\n"), 1)

    def test_orders_of_a_file_that_is_not_there_are_bad_input(self):
        self.sim_server(SCENE)
        server = self.haptic_server("phantom", "--commands", self.folder / "none")
        self.assert_refused(server, daemons.BAD_INPUT, "--commands", "none", "expected a file that can be read")

    def test_a_grippers_spring_holds_what_the_hand_closes(self):
        self.sim_server(SCENE)
        server = self.haptic_server("phantom:gripper_m=0.03,grip_N=1", "--gripper-stiffness", 100)

        def device():
            told = subprocess.run([BUILD / "bin" / "segment_inspect", "--session", self.session, "--json"],
                                  capture_output=True, text=True)
            tool = json.loads(told.stdout).get("tool") if told.returncode == 0 else None
            return (tool or {}).get("latest_state", {}).get("device", {})
        self.wait_until(lambda: abs((device().get("gripper_m") or 0.0) - 0.02) < 1e-4, 10.0, "no rest at 20 mm")
        self.assertAlmostEqual(device()["gripper_force_N"], 1.0, delta=0.02)
        self.assertEqual(server.stop(), daemons.DONE, server.lines())

    def test_a_spring_for_a_device_without_a_gripper_is_bad_input(self):
        self.sim_server(SCENE)
        server = self.haptic_server("phantom", "--gripper-stiffness", 100)
        self.assert_refused(server, daemons.BAD_INPUT, "phantom", "--gripper-stiffness", "declares a gripper")

    def test_every_installed_driver_is_listed_and_a_device_that_is_not_there_refused(self):
        listed = subprocess.run([BUILD / "bin" / "haptic_server", "--list-devices"], capture_output=True, text=True)
        self.assertEqual((listed.returncode, listed.stderr), (0, ""))
        rows = {line.split()[0]: line.split()[1:] for line in listed.stdout.splitlines()}
        self.assertEqual(rows["phantom"], ["phantom", "simulated"])
        self.assertIn("replay", rows)
        self.sim_server(SCENE)
        self.assert_refused(self.haptic_server("phantom@1"), daemons.DEVICE_FAULT, "phantom", "there is only device 0")


if __name__ == "__main__":
    daemons.main()

"""Faults that are injected from outside, each a function of the run."""
import os
import signal
import subprocess
import time

from faults import shared_words
from faults.shared_words import SharedWords, spoil

STAND_STILL_S = 0.4


def signal_sim(number):
    def inject(run):
        run.begin()
        run.sim.signal(number)
    return inject


def stop_sim(for_s):
    def inject(run):
        run.begin()
        run.sim.signal(signal.SIGSTOP)
        time.sleep(for_s)
        run.sim.signal(signal.SIGCONT)
        run.end()
    return inject


def stop_and_go(run):
    run.begin()
    for _ in range(4):
        run.sim.signal(signal.SIGSTOP)
        time.sleep(0.08)
        run.sim.signal(signal.SIGCONT)
        time.sleep(0.05)
    run.end()


def replace_sim(scene, after_s=0.0):
    def inject(run):
        run.begin()
        run.sim.signal(signal.SIGKILL)
        time.sleep(after_s)
        run.sim = run.sim_server(run.scene_argument(scene))
        run.end()
    return inject


def spoil_scene(offset, type_, count, value, is_in_slots=True):
    """Of a scene that goes on."""
    def inject(run):
        words = SharedWords(run.session, "scene")
        places = (words.in_slots(offset, type_, count) if is_in_slots
                  else [words.at(offset, type_, count)])
        run.begin()
        spoil(places, value, STAND_STILL_S)
        run.end()
    return inject


def spoil_stopped_scene(run):
    """The last snapshot claims to be of the time to come, and no other follows."""
    words = SharedWords(run.session, "scene").in_slots(
        shared_words.PAYLOAD + shared_words.PUBLISH_TIMES, "u8", 2)
    run.begin()
    run.sim.signal(signal.SIGSTOP)
    spoil(words, time.monotonic_ns() + 60_000_000_000, STAND_STILL_S)
    run.sim.signal(signal.SIGCONT)
    run.end()


def spoil_sphere(offset, count, value):
    """Floats of the first sphere."""
    return spoil_scene(shared_words.PAYLOAD + shared_words.FIRST_SPHERE + offset, "f4", count,
                       value)


def spoil_states(run):
    """All that a snapshot tells for the simulation to go on elsewhere, and that it is another state."""
    words = SharedWords(run.session, "scene")
    places = words.states() + words.in_slots(shared_words.PAYLOAD + shared_words.STATE_HASH, "u1", 8)
    run.begin()
    spoil(places, 0xFF, STAND_STILL_S)
    run.end()


def truncate(kind):
    def inject(run):
        run.begin()
        os.truncate(shared_words.segment_file(run.session, kind), 0)
    return inject


def unlink(kind):
    def inject(run):
        run.begin()
        shared_words.segment_file(run.session, kind).unlink()
        run.end()
    return inject


def stop_hand(run):
    run.hand.signal(signal.SIGSTOP)
    time.sleep(STAND_STILL_S)
    run.begin()
    run.hand.signal(signal.SIGCONT)
    run.end()


def stop_both(run):
    run.hand.signal(signal.SIGSTOP)
    run.sim.signal(signal.SIGSTOP)
    time.sleep(STAND_STILL_S)
    run.begin()
    run.sim.signal(signal.SIGCONT)
    run.hand.signal(signal.SIGCONT)
    run.end()


def fill_disk(run):
    run.begin()
    size = run.recording.stat().st_size
    subprocess.run(["prlimit", "--pid", str(run.hand.pid), f"--fsize={size + 5000}"],
                   check=True)


def remove_recording(run):
    run.begin()
    run.recording.unlink()


def signal_hand(number):
    def inject(run):
        run.begin()
        run.hand.signal(number)
    return inject


def signal_worker(number):
    """To the process that holds the device."""
    def inject(run):
        run.begin()
        os.kill(run.hand.pid, number)
    return inject


def trigger(run):
    run.begin()
    run.log.trigger()


def kill_guardian(run):
    run.begin()
    run.hand.process.kill()


def after_trigger(inject):
    """The driver does its part first."""
    def both(run):
        run.log.trigger()
        time.sleep(0.1)
        inject(run)
    return both


def kill_hand_and_start_again(run):
    run.hand.signal(signal.SIGKILL)
    run.hand.wait()
    run.begin()
    run.hand = run.start_hand()
    run.end()
    run.wait_until(run.has_been_zero, 5.0, "the next one at work")

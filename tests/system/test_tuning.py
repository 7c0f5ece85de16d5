"""Tuning the running daemon: nothing steps, what may not change is refused, and there is a way back."""
import csv
import os
import pathlib
import random
import re
import shutil
import signal
import stat
import subprocess
import time

import pytest

RELEASE_S = 1.2
RETUNE_S = 0.5
BOX = '\n[[payload]]\nname = "box"\nmass = 0.5\ncom = [0.02, 0, 0]\ninertia = [1e-3, 1e-3, 1e-3]\n'


@pytest.fixture
def robot(robot_file, tmp_path):
    """A copy of planar2r, with a payload, that a test may spoil."""
    folder = pathlib.Path(tmp_path, "robot")
    shutil.copytree(robot_file("planar2r").parent, folder)
    file = folder / "robot.toml"
    text = file.read_text(encoding="utf-8") + BOX
    file.write_text(text.replace('[control]\n', f'[control]\nretune_s = {RETUNE_S}\n'),
                    encoding="utf-8")
    return file


class Tuned:
    """The pair in simulated time, with a trace of every cycle."""

    def __init__(self, pair, robot, law, sim=(), daemon=()):
        self.it = pair(robot)
        self.robot = robot
        self.sim = self.it.sim("--lockstep", "--release", RELEASE_S, *sim)
        self.trace = self.it.folder / "daemon.csv"
        self.program = self.it.daemon("--simulated-time", "--law", law, "--trace", self.trace,
                                      "--trace-hz", 1000, *daemon)
        self.it.wait_for_state("active")
        self.pass_time(RELEASE_S + 1.0)

    def status(self):
        return self.it.status.status()

    def pass_time(self, seconds):
        """Lets so much simulated time go by."""
        until = self.status()["time_s"] + seconds
        end = time.monotonic() + 60
        while self.status()["time_s"] < until:
            assert time.monotonic() < end, self.it.logs()
            time.sleep(0.02)

    def command(self, *arguments):
        return subprocess.run([self.it.binaries / "geodesic", "tune", self.robot, *arguments,
                               "--socket", self.it.socket],
                              capture_output=True, text=True, timeout=20, check=False)

    def tune(self, *arguments):
        run = self.command(*arguments)
        assert run.returncode == 0, (arguments, run.stdout, run.stderr)
        return run.stdout

    def wait_for_log(self, text, seconds=10.0):
        self.program.wait_for(text, seconds)

    def end(self):
        """The commands of the whole run, one row a cycle."""
        status = self.status()
        assert self.program.stop() == 0, self.it.logs()
        self.sim.stop()
        summary = self.it.summary("daemon")
        # A payload that is not there, or not counted, is felt as a contact.
        assert all(f["name"] == "contact" for f in summary["faults"]), summary["faults"]
        assert summary["allocations"] == 0, "the real-time thread allocated"
        assert status["telemetry_dropped"] == 0, "the trace has gaps"
        with open(self.trace, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def steps(rows, start_s, end_s):
    """Largest change of each joint's command from one cycle to the next while active [N·m]."""
    names = [name for name in rows[0] if name.startswith("command_")]
    largest = dict.fromkeys(names, 0.0)
    for before, after in zip(rows, rows[1:]):
        if before["state"] != "active" or not start_s <= float(before["time_s"]) < end_s:
            continue
        for name in names:
            largest[name] = max(largest[name], abs(float(after[name]) - float(before[name])))
    return max(largest.values())


def moved(rows, start_s, end_s):
    """Largest excursion of a joint [rad]."""
    window = [row for row in rows if start_s <= float(row["time_s"]) < end_s]
    return max(max(float(r[n]) for r in window) - min(float(r[n]) for r in window)
               for n in window[0] if n.startswith("q_"))


@pytest.mark.parametrize("law", ["float", "hold"])
def test_nothing_steps(pair, robot, law):
    """Gains, friction, filter and payload change in turn: torque from cycle to cycle changes by no
    more than it does anyway plus what a linear fade of the whole difference within retune_s makes."""
    it = Tuned(pair, robot, law)
    quiet_s = it.status()["time_s"]
    it.pass_time(0.5)
    first_s = it.status()["time_s"]
    for values in [("joint.joint1.hold_stiffness=20", "joint.joint2.hold_stiffness=60"),
                   ("joint.joint1.hold_damping=3", "joint.joint1.damping=0.2"),
                   ("joint.joint1.coulomb_friction=0.1", "control.velocity_filter_hz=60")]:
        it.tune(*values)
        it.pass_time(RETUNE_S + 0.2)
    gains_s = it.status()["time_s"]
    if law == "hold":
        assert '"none" -> "box"' in it.tune("payload=box")
        it.pass_time(2 * RETUNE_S)
        assert it.status()["tuning"]["payload"] == "box"
        assert '"box" -> "none"' in it.tune("--undo")
        it.pass_time(2 * RETUNE_S)
    last_s = it.status()["time_s"]
    rows = it.end()
    noise = steps(rows, quiet_s - 0.2, first_s)
    assert steps(rows, first_s, gains_s) < 1.5 * noise + 0.02
    assert moved(rows, first_s, gains_s) < 2e-3
    if law == "hold":
        # 0.5 kg at 0.9 m: 4.5 N·m at most, over 500 cycles; the arm gives by that over its spring.
        # While it moves, one digit of the drive's velocity (0.022 rad/s) times the damping shows.
        whole = 0.5 * 9.81 * 0.95
        assert steps(rows, gains_s, last_s) < 2.0 * whole / (RETUNE_S * 1000) + 0.03
        assert moved(rows, gains_s, last_s) < 1.3 * whole / 20


def test_payload_floats_and_sinks_without(pair, robot):
    """The arm really carries the box: it floats as long as the daemon counts with it."""
    text = robot.read_text(encoding="utf-8")
    robot.write_text(text.replace("[robot]\n", '[robot]\npayload = "box"\n'), encoding="utf-8")
    it = Tuned(pair, robot, "float", sim=("--payload", "box"))
    start_s = it.status()["time_s"]
    it.pass_time(2.0)
    carried_s = it.status()["time_s"]
    it.tune("payload=none", "joint.joint1.damping=8", "joint.joint2.damping=8")  # slowly
    it.pass_time(0.5)
    tuned_s = it.status()["time_s"]
    it.tune("--undo")
    it.pass_time(0.1)
    rows = it.end()
    assert moved(rows, start_s, carried_s) < 1e-3
    assert moved(rows, carried_s, tuned_s) > 0.02, "without it the arm must sink"


def test_bad_file_changes_nothing(pair, robot):
    it = Tuned(pair, robot, "hold")
    good = robot.read_text(encoding="utf-8")
    listed = it.tune("--list")
    robot.write_text(good.replace("hold_stiffness = 40", "hold_stiffness = -40"), encoding="utf-8")
    line = good[:good.index("hold_stiffness = 40")].count("\n") + 1
    it.wait_for_log(f"robot.toml:{line}:18: error: hold_stiffness: found the integer -40")
    assert it.status()["tuning"]["last"]["ok"] is False
    assert "hold_stiffness" in it.status()["tuning"]["last"]["messages"][0]
    robot.write_text(good.replace("rate_hz = 1000", "rate_hz = 500")
                     .replace("hold_stiffness = 40", "hold_stiffness = 30"), encoding="utf-8")
    it.wait_for_log("robot.rate_hz: 1000 -> 500 Hz needs a restart")
    assert it.tune("--list") == listed, "all or nothing"
    robot.write_text(good.replace("hold_stiffness = 40", "hold_stiffness = 30"), encoding="utf-8")
    it.wait_for_log("file: joint.joint1.hold_stiffness: 40 -> 30 N·m/rad")
    last = it.status()["tuning"]["last"]
    assert (last["ok"], last["by"], last["changed"]) == (True, "file", 2)
    it.program.send(signal.SIGHUP)
    it.wait_for_log("signal: read; nothing that counts here is different")
    it.end()


def test_file_and_folder_gone(pair, robot):
    """Removed, or its whole folder: the daemon says so, goes on, and reads it again once it is back."""
    it = Tuned(pair, robot, "hold")
    good = robot.read_text(encoding="utf-8")
    robot.unlink()
    it.wait_for_log("there is no file")
    aside = robot.parent.with_name("aside")
    robot.parent.rename(aside)
    it.wait_for_log("cannot be watched")
    assert "1.75" in it.command("joint.joint1.hold_damping=1.75").stdout + it.tune("--list")
    assert it.status()["state"] == "active"
    aside.rename(robot.parent)
    robot.write_text(good.replace("hold_stiffness = 40", "hold_stiffness = 30"), encoding="utf-8")
    it.wait_for_log("file: joint.joint1.hold_stiffness: 40 -> 30 N·m/rad")
    it.end()


def test_refusals_name_the_option(pair, robot):
    text = robot.read_text(encoding="utf-8")
    robot.write_text(re.sub(r"\[simulation.pose\]\n.*\n.*\n", "", text), encoding="utf-8")
    it = Tuned(pair, robot, "hold", sim=("--pose=0.5,-0.8",))
    listed = it.tune("--list")
    for value, expected in [
            ("joint.joint1.hold_stifness=30", 'did you mean "joint.joint1.hold_stiffness"?'),
            ("joint.joint1.hold_stiffness=-3", "at least 0"),
            ("robot.rate_hz=500", "robot.rate_hz needs a restart"),
            ("payload=bxo", 'did you mean "box"?'),
            ("joint.joint1.position_upper=0.1", "excludes the arm as it is: this joint is at 0.5"),
            ("joint.joint1.torque_limit=1", "is held up by"),
            ("joint.joint1.position_upper=99", "outside what the drive can count")]:
        run = it.command("joint.joint2.hold_damping=3", value)
        assert run.returncode == 1 and expected in run.stderr, (value, run.stdout, run.stderr)
    assert it.command().returncode == 1 and it.command("nonsense").returncode == 1
    answer = it.it.status.ask(cmd="tune", set=["a"])
    assert answer["ok"] is False and "object" in answer["error"]
    assert it.tune("--list") == listed
    it.end()


def test_write_keeps_the_file(pair, robot):
    """--write changes the bytes of the values and no others; mode and comments stay."""
    it = Tuned(pair, robot, "hold")
    robot.chmod(0o640)
    before = robot.read_text(encoding="utf-8")
    it.tune("joint.joint2.hold_stiffness=25", "control.velocity_filter_hz=80", "payload=box")
    assert "written" in it.tune("--write")
    after = robot.read_text(encoding="utf-8")
    expected = before.replace("velocity_filter_hz = 100", "velocity_filter_hz = 80")
    expected = expected.replace('tool_link = "tip"\n', 'tool_link = "tip"\npayload = "box"\n')
    line = 'simulation = { coulomb_friction = 0.1, viscous_friction = 0.02 }\n'
    assert after == expected.replace(line, line + "hold_stiffness = 25\n")
    assert stat.S_IMODE(os.stat(robot).st_mode) == 0o640
    it.wait_for_log("takes the place of the tuned")  # the file says so itself now
    status = it.status()
    assert status["tuning"]["tuned"] == [] and status["tuning"]["payload"] == "box"
    assert status["tuning"]["last"]["changed"] == 0, "nothing may have changed by it"
    it.end()


def memory_kib(pid):
    text = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return int(re.search(r"^VmRSS:\s*(\d+)", text, re.M)[1])


def test_a_thousand_tunes(pair, robot):
    """One after the other while another client asks for status all the time: none steps the torque,
    none is lost, nothing leaks, and taking all of them back leads to where it began."""
    it = Tuned(pair, robot, "hold")
    listed = it.tune("--list")
    generator = random.Random(3)
    quiet_s = it.status()["time_s"]
    it.pass_time(0.3)
    first_s = it.status()["time_s"]
    memory = 0
    for number in range(1000):
        joint = generator.choice(["joint1", "joint2"])
        key, value = generator.choice([
            ("hold_stiffness", generator.uniform(20, 60)), ("hold_damping", generator.uniform(1, 3)),
            ("coulomb_friction", generator.uniform(0, 0.2)), ("rotor_inertia", 0.012),
            ("damping", generator.uniform(0, 1))])
        answer = it.it.status.ask(cmd="tune", set={f"joint.{joint}.{key}": value})
        assert answer["ok"], answer
        if number % 10 == 0:
            assert it.status()["state"] == "active"
        if number == 300:  # what is kept for undo has grown, buffers have their size
            memory = memory_kib(it.program.process.pid)
    assert it.status()["tuning"]["undoable"] == 1000
    assert memory_kib(it.program.process.pid) < memory + 4096
    last_s = it.status()["time_s"]
    for _ in range(1000):
        answer = it.it.status.ask(cmd="tune", undo=True)
        assert answer["ok"], answer
    assert it.it.status.ask(cmd="tune", undo=True)["ok"] is False
    assert it.tune("--list") == listed
    assert it.status()["tuning"]["tuned"] == []
    rows = it.end()
    assert steps(rows, first_s, last_s) < 2.0 * steps(rows, quiet_s - 0.2, first_s) + 0.05
    assert moved(rows, first_s, last_s) < 0.01

"""Stops, commands and refusals between people and the daemon. What goes wrong by itself, and what
must follow, is in faults.toml."""
import json
import pathlib
import re
import signal
import subprocess
import time

import pytest

RELEASE_S = 1.2

def changed(robot_file, tmp_path, pattern, replacement):
    source = robot_file("planar2r")
    text = source.read_text(encoding="utf-8")
    text, count = re.subn(pattern, replacement, text, count=1, flags=re.M)
    assert count == 1, f"{pattern} is not in {source}"
    folder = pathlib.Path(tmp_path, "changed")
    folder.mkdir()
    (folder / "planar2r.urdf").write_bytes((source.parent / "planar2r.urdf").read_bytes())
    (folder / "robot.toml").write_text(text, encoding="utf-8")
    return folder / "robot.toml"


@pytest.fixture
def unhurried(robot_file, tmp_path):
    """planar2r at 200 Hz: what a machine without real time, a virtual one too, can keep up with.
    For tests whose point is wall-clock time; the others run at 1 kHz of simulated time."""
    return changed(robot_file, tmp_path, r"^rate_hz *= *\d+", "rate_hz = 200")


def test_second_daemon_is_refused(pair, binaries, tmp_path):
    it = pair("planar2r")
    it.sim("--release", RELEASE_S, "--lockstep")
    it.daemon("--simulated-time")
    it.wait_for_state("active")
    second = subprocess.run(
        [binaries / "geodesicd", it.robot, *it.bus_arguments, "--socket", tmp_path / "other.sock",
         "--simulated-time"], capture_output=True, text=True, timeout=20, check=False)
    assert second.returncode == 1
    assert "already" in second.stderr + second.stdout
    assert it.status.status()["state"] == "active", "the first one must not have noticed"


def test_sigterm_is_a_controlled_stop(pair):
    it = pair("planar2r")
    sim = it.sim("--release", RELEASE_S, "--lockstep")
    daemon = it.daemon("--simulated-time")
    it.wait_for_state("active")
    time.sleep(0.5)
    assert daemon.stop() == 0, it.logs()
    sim.stop()
    summary, truth = it.summary("daemon"), it.summary("sim")
    assert summary["final_state"] == "off" and summary["faults"] == []
    assert all(joint["enabled"] is False and joint["watchdog_trips"] == 0
               for joint in truth["joints"]), truth


def test_stop_and_law_by_command(pair, binaries):
    it = pair("planar2r")
    it.sim("--release", RELEASE_S, "--lockstep")
    it.daemon("--simulated-time")
    it.wait_for_state("active")
    geodesic = lambda *a: subprocess.run(  # noqa: E731
        [binaries / "geodesic", *a, "--socket", it.socket], capture_output=True, text=True,
        timeout=20, check=False)
    assert geodesic("law", "hold").returncode == 0
    time.sleep(0.3)
    assert it.status.status()["law"] == "hold"
    typo = geodesic("law", "flaot")
    assert typo.returncode != 0 and "float" in typo.stderr + typo.stdout
    assert geodesic("stop").returncode == 0
    it.wait_for_state("off")
    shown = geodesic("status", "--once")
    assert shown.returncode == 0 and "joint1" in shown.stdout, shown
    assert json.loads(geodesic("status", "--json", "--once").stdout)["state"] == "off"
    # It swings down after `off`, and a moving arm is not started: ask until it hangs at rest.
    for _ in range(40):
        assert geodesic("law", "float").returncode == 0
        time.sleep(0.5)
        if it.status.status()["state"] == "active":
            break
    it.wait_for_state("active")


def test_interrupt_while_connecting(pair, realtime, unhurried):
    """Nobody answers: the daemon says who is silent, and SIGINT ends it at once."""
    it = pair(unhurried)
    sim = it.sim()
    sim.send(signal.SIGSTOP)
    daemon = it.daemon(*realtime)
    time.sleep(1.0)
    daemon.send(signal.SIGINT)
    status = daemon.wait(20)
    sim.send(signal.SIGCONT)
    assert status == 0, it.logs()


@pytest.mark.parametrize("pattern, replacement, expected", [
    (r"^rate_hz *= *\d+", "rate_hz = 4000", "rate"),
    (r"^name *= *\"joint2\"", 'name = "jiont2"', "joint2"),
    (r"^urdf *= *.*$", 'urdf = "missing.urdf"', "missing.urdf"),
    (r"^\[robot\]$", "[robot]\nnonsense = 1", "nonsense"),
    (r"^\[robot\]$", "[robot", "robot.toml:"),
])
def test_bad_config(binaries, robot_file, tmp_path, pattern, replacement, expected):
    """Refused with file, line and column; nothing is started and no summary pretends otherwise."""
    robot = changed(robot_file, tmp_path, pattern, replacement)
    for program in (["geodesicd"], ["geodesic", "check"], ["geodesic", "sim"]):
        run = subprocess.run([binaries / program[0], *program[1:], robot, "--bus",
                              f"unix:{tmp_path}/b"], capture_output=True, text=True, timeout=20,
                             check=False)
        said = run.stdout + run.stderr
        assert run.returncode == 1, (program, said)
        assert re.search(r"(robot\.toml|\.urdf):\d+:\d+: error:", said), (program, said)
        assert expected in said, (program, said)


def test_drive_contradicts_config(pair, robot_file, tmp_path):
    """The drive's own range is not the configured one: refused before any torque, by register."""
    it = pair("planar2r")
    sim = it.sim("--lockstep")
    source = robot_file("planar2r").read_text(encoding="utf-8")
    wrong = re.sub(r"velocity_range_rad_s *= *[\d.]+", "velocity_range_rad_s = 30.0", source)
    assert wrong != source
    folder = pathlib.Path(tmp_path, "wrong")
    folder.mkdir()
    (folder / "robot.toml").write_text(wrong, encoding="utf-8")
    urdf = robot_file("planar2r").parent / "planar2r.urdf"
    (folder / "planar2r.urdf").write_bytes(urdf.read_bytes())
    it.robot = folder / "robot.toml"
    daemon = it.daemon("--exit-on-fault", "--simulated-time")
    assert daemon.wait(30) == 3, it.logs()
    assert "VMAX" in daemon.output() and "drive_refused" in daemon.output()
    sim.stop()
    assert all(joint["max_torque"] == 0 for joint in it.summary("sim")["joints"])

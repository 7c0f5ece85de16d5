"""A daemon with a compiled model floats the arm as one without, and only with the right model."""
import csv
import json
import os
import pathlib
import shutil
import subprocess

import pytest

BOX = '\n[[payload]]\nname = "box"\nmass = 0.05\ncom = [0.02, 0, 0]\ninertia = [1e-4, 1e-4, 1e-4]\n'
SECONDS = 3


@pytest.fixture
def robot(robot_file, tmp_path):
    """A copy of planar2r, with a payload, that a test may spoil."""
    folder = pathlib.Path(tmp_path, "robot")
    shutil.copytree(robot_file("planar2r").parent, folder)
    file = folder / "robot.toml"
    file.write_text(file.read_text(encoding="utf-8") + BOX, encoding="utf-8")
    return file


def compile_(binaries, robot, *arguments, **environment):
    return subprocess.run([binaries / "geodesic", "compile", robot, *arguments],
                          capture_output=True, text=True, timeout=120, check=False,
                          env={**os.environ, **environment})


def torques(pair, robot, *daemon):
    """Commands of a released arm that swings, cycle by cycle, and the run's summary."""
    it = pair(robot)
    sim = it.sim("--lockstep", "--release", 0.5)
    trace = it.folder / "daemon.csv"
    program = it.daemon("--simulated-time", "--seconds", SECONDS, "--trace", trace, "--trace-hz",
                        1000, *daemon)
    assert program.wait() == 0, it.logs()
    sim.stop()
    with open(trace, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return rows, it.summary("daemon"), program.output()


def test_floats_the_same(pair, robot, binaries):
    """Torques differ by less than the drives can tell; the record says which model was at work."""
    made = compile_(binaries, robot, "--json")
    assert made.returncode == 0, made.stderr
    said = json.loads(made.stdout)
    assert said["agreement"]["worst"] <= said["agreement"]["allowed"] == 1e-12
    assert said["agreement"]["states"] == 1000
    assert pathlib.Path(said["file"]) == robot.with_name("robot.compiled.so")

    plain, summary, _ = torques(pair, robot)
    assert summary["model"]["path"] == "interpreted"
    assert summary["model"]["fingerprint"] == said["fingerprint"]
    robot.write_text(robot.read_text(encoding="utf-8").replace(
        "[control]\n", '[control]\ncompiled = "robot.compiled.so"\n'), encoding="utf-8")
    rows, summary, log = torques(pair, robot)
    assert summary["model"]["path"] == "compiled"
    assert summary["model"]["fingerprint"] == said["fingerprint"] and said["fingerprint"] in log
    assert summary["allocations"] == 0 and not summary["faults"]
    names = [name for name in rows[0] if name.startswith(("command_", "q_"))]
    active = [(a, b) for a, b in zip(plain, rows) if a["state"] == b["state"] == "active"]
    assert len(active) > 1000 * (SECONDS - 2)
    assert max(abs(float(a["command_joint1"])) for a, _ in active) > 0.1
    for name in names:
        assert max(abs(float(a[name]) - float(b[name])) for a, b in active) < 0.02, name


def test_another_mechanism_is_never_run(pair, robot, binaries):
    """A payload that is tuned takes the compiled model out, undoing puts it back; a start with
    another mechanism than it was built for is refused with the command that helps."""
    assert compile_(binaries, robot).returncode == 0
    compiled = robot.with_name("robot.compiled.so")
    it = pair(robot)
    sim = it.sim("--lockstep")
    program = it.daemon("--simulated-time", "--compiled", compiled)
    it.wait_for_state("active")
    tune = [binaries / "geodesic", "tune", robot, "--socket", it.socket]
    subprocess.run([*tune, "payload=box"], check=True, timeout=20, capture_output=True)
    program.wait_for("takes over until the change is taken back", 10)
    subprocess.run([*tune, "joint.joint1.damping=0.3"], check=True, timeout=20,
                   capture_output=True)
    subprocess.run([*tune, "--undo"], check=True, timeout=20, capture_output=True)
    assert "counts again" not in program.output()
    subprocess.run([*tune, "--undo"], check=True, timeout=20, capture_output=True)
    program.wait_for("counts again", 10)
    assert program.stop() == 0, it.logs()
    sim.stop()

    robot.write_text(robot.read_text(encoding="utf-8").replace(
        "[robot]\n", '[robot]\npayload = "box"\n'), encoding="utf-8")
    refused = subprocess.run([binaries / "geodesicd", robot, "--compiled", compiled,
                              "--simulated-time", "--bus", f"unix:{it.folder}/none"],
                             capture_output=True, text=True, timeout=20, check=False)
    assert refused.returncode == 1
    assert "another mechanism" in refused.stderr and "geodesic compile" in refused.stderr


def test_without_a_compiler(robot, binaries):
    """Named with the package; nothing is left behind."""
    made = compile_(binaries, robot, PATH="/nowhere")
    assert made.returncode == 1 and "apt install g++" in made.stderr
    assert not list(robot.parent.glob("*.so*"))

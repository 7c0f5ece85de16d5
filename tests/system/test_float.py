"""Law float holds every robot where it is left: ten poses, twenty simulated seconds each."""
import json
import random
import subprocess

import pytest

SECONDS = 20
RELEASE_S = 1.5
ROBOTS = ["planar2r", "quad12", "openarm", "openarm-bimanual"]


def pose(binaries, robot, number):
    """A pose well inside the joint limits, the same one every time."""
    model = json.loads(subprocess.run([binaries / "geodesic", "model", robot, "--json"],
                                      check=True, capture_output=True, text=True).stdout)
    generator = random.Random(number)
    values = []
    for joint in model["joints"]:
        lower, upper = max(joint["lower"], -2.5), min(joint["upper"], 2.5)
        margin = 0.2 * (upper - lower)
        values.append(round(generator.uniform(lower + margin, upper - margin), 4))
    return ",".join(map(str, values))


@pytest.mark.parametrize("number", range(10))
@pytest.mark.parametrize("robot", ROBOTS)
def test_float_holds(pair, binaries, robot_file, robot, number):
    it = pair(robot)
    start = pose(binaries, robot_file(robot), number)
    sim = it.sim("--lockstep", "--release", RELEASE_S, f"--pose={start}")
    daemon = it.daemon("--simulated-time", "--seconds", SECONDS + RELEASE_S)
    assert daemon.wait(200) == 0, it.logs()
    sim.stop()
    summary, truth = it.summary("daemon"), it.summary("sim")
    assert summary["faults"] == [], it.logs()
    assert summary["final_state"] == "off"
    assert summary["cycles"] > SECONDS * 1000
    assert all(joint["losses"] == 0 for joint in summary["joints"])
    free = truth["drift_by_second"][:SECONDS]  # after them the daemon lowers the arm
    assert len(free) == SECONDS, "the stand let go too late: nothing was proven"
    assert max(free) < 1e-3, truth


@pytest.mark.parametrize("robot", ROBOTS)
def test_without_compensation_it_falls(pair, robot):
    """The same arrangement can fail: with law zero the arm does not stay."""
    it = pair(robot)
    sim = it.sim("--lockstep", "--release", RELEASE_S)
    daemon = it.daemon("--simulated-time", "--seconds", 3 + RELEASE_S, "--law", "zero",
                       "--allow-zero-law")
    daemon.wait(100)
    sim.stop()
    assert it.summary("sim")["drift_by_second"][0] > 0.1, it.logs()

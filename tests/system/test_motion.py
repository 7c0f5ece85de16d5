"""Motion against physics: a push accelerates the arm as its mass matrix says, and nothing moves
before the drives are told to."""
import json
import subprocess
import tomllib

import motion
import numpy
import pytest

RELEASE_S = 1.5


@pytest.mark.parametrize("robot, joint, torque", [
    ("planar2r", "joint2", 3.0), ("openarm", "openarm_joint4", 4.0)])
def test_push_accelerates_as_physics_says(pair, binaries, robot_file, robot, joint, torque):
    """Short push from rest: M(q) a = push - friction at t = 0, friction as the file says."""
    it = pair(robot)
    trace = it.folder / "truth.csv"
    push_s = 0.02
    sim = it.sim("--lockstep", "--release", RELEASE_S, "--trace", trace, "--trace-hz", 1000,
                 "--push", f"{joint}:{torque}@1.0+{push_s}")
    daemon = it.daemon("--simulated-time", "--seconds", RELEASE_S + 2.0)
    assert daemon.wait(100) == 0, it.logs()
    sim.stop()
    truth = motion.read(trace)
    index = truth["joints"].index(joint)
    pushed = motion.between(truth, 1.0, 1.0 + push_s - 1e-9)
    first, last = pushed[2], pushed[-1]
    found = ((truth["v"][index][last] - truth["v"][index][first])
             / (truth["time"][last] - truth["time"][first]))
    expected = predicted(binaries, robot_file(robot), truth, first, index, torque)
    assert found == pytest.approx(expected, rel=0.1)


def predicted(binaries, robot, truth, sample, pushed, torque):
    """Acceleration of the pushed joint: M a = push - dry friction, with M by the model, rotors and
    friction as the file gives them to the simulated arm."""
    count = len(truth["joints"])
    states = {"states": [{"q": [column[sample] for column in truth["q"]],
                          "v": [0.0] * count, "a": [0.0] * count}]}
    model = json.loads(subprocess.run(
        [binaries / "geodesic", "model", robot, "--json", "--states", "/dev/stdin"],
        input=json.dumps(states), check=True, capture_output=True, text=True).stdout)
    simulated = [simulation(robot, name) for name in truth["joints"]]
    metric = numpy.array(model["states"][0]["M"]) + numpy.diag(
        [joint.get("rotor_inertia", 0.0) for joint in simulated])
    dry = numpy.array([joint.get("coulomb_friction", 0.0) for joint in simulated])
    push = numpy.zeros(count)
    push[pushed] = torque
    # Joints that the push moves are braked by all their dry friction, the others stick.
    moving = numpy.arange(count) == pushed
    for _ in range(50):
        a = numpy.zeros(count)
        direction = numpy.sign(numpy.linalg.solve(metric, push))
        free = numpy.ix_(moving, moving)
        a[moving] = numpy.linalg.solve(metric[free], (push - dry * direction)[moving])
        stuck = (numpy.abs(push - metric @ a) > dry) & ~moving
        if not stuck.any():
            break
        moving |= stuck
    return a[pushed]


def simulation(robot, joint):
    with open(robot, "rb") as file:
        content = tomllib.load(file)
    for entry in content["joint"]:
        if entry["name"] == joint:
            whole = content.get("defaults", {}).get("joint", {}) | entry
            return {"rotor_inertia": whole.get("rotor_inertia", 0.0)} | whole.get("simulation", {})
    raise AssertionError(f"{joint} is not in {robot}")


@pytest.mark.parametrize("robot", ["planar2r", "openarm", "openarm-bimanual"])
@pytest.mark.parametrize("number", range(3))
def test_start_moves_nothing(pair, binaries, robot_file, robot, number):
    """From any pose, no joint moves by more than an encoder step before `active`, nor by the ramp."""
    from test_float import pose
    it = pair(robot)
    sim = it.sim("--lockstep", "--release", RELEASE_S,
                 f"--pose={pose(binaries, robot_file(robot), 100 + number)}")
    daemon = it.daemon("--simulated-time", "--seconds", 0.2)
    assert daemon.wait(100) == 0, it.logs()
    sim.stop()
    for joint in it.summary("sim")["joints"]:
        assert joint["moved_before_release"] < joint["encoder_step"], joint

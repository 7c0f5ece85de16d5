#!/usr/bin/env python3
"""`geodesic shoot` as people call it: free motion, the way between two poses, files, refusals, and a
million steps of a free-floating arm."""

import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ARM = HERE.parent.parent / "config/robots/planar2r/planar2r.urdf"
ROBOT = HERE.parent.parent / "config/robots/planar2r/robot.toml"

# A box that floats, with an arm of three rods.
FLOATER = """<robot name="floater">
<link name="box"><inertial><origin xyz="0.02 -0.03 0.01"/><mass value="4"/>
<inertia ixx="0.09" iyy="0.12" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link>
""" + "".join(f"""<link name="rod{i}"><inertial><origin xyz="0.2 0.01 -0.02"/><mass value="{1.1 - 0.1 * i}"/>
<inertia ixx="0.001" iyy="0.013" izz="0.013" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="joint{i}" type="continuous"><parent link="{parent}"/><child link="rod{i}"/>
<origin xyz="{0.2 if i == 1 else 0.4} 0 0"/><axis xyz="{axis}"/></joint>
""" for i, parent, axis in ((1, "box", "0 0 1"), (2, "rod1", "0 1 0"), (3, "rod2", "0 0.6 0.8"))) + "</robot>"


def check(condition, text):
    if not condition:
        sys.exit(f"geodesic shoot: {text}")


def call(*words):
    return subprocess.run([sys.argv[1], "shoot", *map(str, words)], capture_output=True, text=True)


def answer(*words):
    done = call(*words, "--json")
    check(done.returncode == 0, f"{words}: {done.stderr}")
    return json.loads(done.stdout)


def refused(status, text, *words):
    done = call(*words)
    check(done.returncode == status, f"{words}: status {done.returncode}, expected {status}")
    check(text in done.stderr, f"{words}: {done.stderr!r} does not say {text!r}")


def free_motion():
    start = [ARM, "--q=0.3,-0.5", "--v=1,-2", "--duration", 2]
    steady = answer(*start, "--steps", 4000)
    fine = answer(*start, "--steps", 4000, "--integrator", "runge-kutta")
    check(steady["integrator"] == "variational" and fine["integrator"] == "runge-kutta", "names")
    ends = [shot["trajectory"]["q"][-1] for shot in (steady, fine)]
    check(math.dist(*ends) < 1e-5, f"the integrators disagree: {ends}")
    check(fine["energy"]["largest_change"] < 1e-9, "a geodesic keeps its kinetic energy")
    check(steady["energy"]["largest_change"] < 1e-5, "energy of the variational integrator")
    times = steady["trajectory"]["time"]
    check(times[0] == 0 and abs(times[-1] - 2) < 1e-12 and len(times) == 1001, "instants")
    falls = answer(*start, "--gravity=0,-9.81,0")
    check(falls["energy"]["largest_change"] < 1e-3, "energy under gravity")
    check(falls["trajectory"]["q"][-1] != ends[0], "gravity does nothing")
    check("a geodesic of its kinetic energy" in call(*start).stdout, "words")


def between():
    there = answer(ROBOT, "--from=0.1,0.2", "--to=1.3,-0.9", "--duration", 2, "--steps", 400)
    back = answer(ROBOT, "--from=1.3,-0.9", "--to=0.1,0.2", "--duration", 2, "--steps", 400)
    found = there["between"]
    check(found["outcome"] == "found" and found["miss"] < 1e-9, str(found))
    check(math.dist(there["trajectory"]["q"][-1], [1.3, -0.9]) < 1e-9, "it does not arrive")
    kinetic = there["trajectory"]["kinetic_energy"]
    check(max(kinetic) - min(kinetic) < 1e-8 * max(kinetic), "kinetic energy is not constant")
    action = found["geodesic"]["action"]
    check(abs(action - 2 * kinetic[0]) < 1e-8 * action, "the action is T times the time")
    check(action < found["straight"]["action"], "the straight line is cheaper")
    check(abs(action - back["between"]["geodesic"]["action"]) < 1e-8 * action, "back and forth")
    check("straight line" in call(ROBOT, "--from=0.1,0.2", "--to=1.3,-0.9").stdout, "words")


def files():
    with tempfile.TemporaryDirectory() as folder:
        table, picture = Path(folder) / "way.csv", Path(folder) / "way.png"
        done = call(ARM, "--to=1,-1", "--csv", table, "--plot", picture)
        check(done.returncode == 0, done.stderr)
        check(picture.read_bytes().startswith(b"\x89PNG"), "the picture is no PNG")
        rows = list(csv.DictReader(table.open()))
        check(len(rows) == 1001 and abs(float(rows[-1]["q " + joint(rows)]) - 1) < 1e-8, "table")
        floater, floating = Path(folder) / "floater.urdf", Path(folder) / "floating.png"
        floater.write_text(FLOATER)
        done = call(floater, "--floating", "--v=0,0,0,0,0,1,2,-1,1", "--plot", floating)
        check(done.returncode == 0 and floating.stat().st_size > 10000, done.stderr)
        refused(1, "nowhere", ARM, "--csv", "/nowhere/way.csv")
        refused(1, "could not be drawn", ARM, "--plot", Path(folder) / "way.wrong")


def joint(rows):
    return next(name[2:] for name in rows[0] if name.startswith("q "))


def million_steps():
    with tempfile.TemporaryDirectory() as folder:
        floater = Path(folder) / "floater.urdf"
        floater.write_text(FLOATER)
        shot = answer(floater, "--floating", "--v=0.05,-0.03,0.02,0.1,-0.2,0.5,1.5,-1,0.8",
                      "--duration", 1000, "--steps", 1000000)
    momentum, energy = shot["momentum"], shot["energy"]
    check(momentum["linear"] < 1e-10 and momentum["angular"] < 1e-10, f"momentum {momentum}")
    check(energy["largest_change"] < 1e-5, f"energy {energy}")
    check(abs(energy["drift"]) < 0.2 * energy["largest_change"], f"energy drifts: {energy}")
    check(len(shot["opening"]["time"]) == 4001, "the opening")
    print(f"a million steps: momentum {momentum}, energy {energy}, {shot['ns_per_step']:.0f} ns each")


def refusals():
    refused(1, "--v: found 3 numbers, expected 2", ARM, "--v=1,2,3")
    refused(1, "expected 2", ARM, "--q=1")
    refused(1, "--q", ARM, "--q=1,nan")
    refused(1, "--v", ARM, "--v=1,fast")
    refused(1, "has length 0", ARM, "--floating", "--q=0,0,0,0,0,0,0,0.1,0.2")
    refused(1, "--duration 0", ARM, "--duration", 0)
    refused(1, "--duration inf", ARM, "--duration", "inf")
    refused(1, "exclude one another", ARM, "--to=1,1", "--v=1,1")
    refused(1, "exclude one another", ARM, "--to=1,1", "--gravity=0,0,-9.81")
    refused(1, "there is no link 'hand'", ARM, "--frame", "hand")
    refused(2, "--steps", ARM, "--steps", 0)
    refused(2, "--integrator", ARM, "--integrator", "euler")
    refused(1, "nothing.urdf", "nothing.urdf")
    refused(1, "no geodesic found", ARM, "--to=400,-900", "--steps", 20)
    refused(1, "metric is singular", ARM, "--floating", "--v=0,0,0,0,0,0,1,1")


free_motion()
between()
files()
refusals()
million_steps()

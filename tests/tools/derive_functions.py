#!/usr/bin/python3
"""`geodesic derive` as users call it: its C by the system's compiler and its .m files in Octave give
the numbers of `geodesic model`; files are never overwritten silently; refusals are clear."""
import ctypes
import json
import pathlib
import random
import subprocess
import sys
import tempfile

GEODESIC, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
ORACLES = ROOT / "tests/data/oracles"
ROBOTS = [  # file, options of derive, options of model, letters too
    (ROOT / "config/robots/planar2r/robot.toml", ["--rotors"], ["--rotors"]),
    (ROOT / "config/robots/planar2r/robot.toml", ["--symbols"], []),
    (ORACLES / "ur5.urdf", ["--as-written", "--gravity", "1,2,-9"], ["--gravity", "1,2,-9"]),
]
BOUND = 1e-10


def geodesic(*arguments):
    return subprocess.run([GEODESIC, *map(str, arguments)], capture_output=True, text=True)


def answer(*arguments):
    done = geodesic(*arguments)
    assert done.returncode == 0, (arguments, done.stderr)
    return done.stdout


def states(robot, options, count=4):
    """q, v and what the mechanism says of them."""
    number = len(json.loads(answer("model", robot, "--json"))["states"][0]["q"])
    random.seed(3)
    for _ in range(count):
        q, v = ([random.uniform(-2, 2) for _ in range(number)] for _ in range(2))
        text = answer("model", robot, "--json", "--q=" + ",".join(map(repr, q)),
                      "--v=" + ",".join(map(repr, v)), *options)
        found = json.loads(text)["states"][0]
        yield q, v, found["M"], [c + g for c, g in zip(found["Cv"], found["g"])]


def close(found, expected, what):
    scale = max(1.0, max(map(abs, expected)))
    worst = max(abs(a - b) for a, b in zip(found, expected, strict=True))
    assert worst < BOUND * scale, f"{what}: {worst} off"


def check_c(robot, derived, evaluated, folder):
    source, library = folder / "arm.c", folder / "arm.so"
    answer("derive", robot, "--format", "c", "--output", source, *derived)
    subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC",
                    source, "-o", library, "-lm"], check=True)
    functions = ctypes.CDLL(str(library))
    for q, v, metric, forces in states(robot, evaluated):
        n = len(q)
        vector, matrix = ctypes.c_double * n, ctypes.c_double * (n * n)
        m, tau = matrix(), vector()
        functions.M_metric(vector(*q), m)
        functions.Cgrav_forces(vector(*q), vector(*v), tau)
        close(list(m), sum(metric, []), f"{robot}: M_metric in C")
        close(list(tau), forces, f"{robot}: Cgrav_forces in C")


def check_octave(robot, derived, evaluated, folder):
    answer("derive", robot, "--format", "matlab", "--output", folder, *derived)
    assert sorted(path.name for path in folder.glob("*.m")) == ["Cgrav_forces.m", "M_metric.m"]
    cases = list(states(robot, evaluated))
    calls = "".join(f"printf('%.17g ', M_metric({q})', Cgrav_forces({q}, {v})); printf('\\n');"
                    for q, v, _, _ in cases)
    done = subprocess.run(["octave-cli", "--no-gui", "--quiet", "--norc", "--eval", calls],
                          cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for line, (q, _, metric, forces) in zip(done.stdout.splitlines(), cases, strict=True):
        close(list(map(float, line.split())), sum(metric, []) + forces, f"{robot}: in Octave")


def check_manners(folder):
    robot = ORACLES / "planar2r.urdf"
    target = folder / "arm.txt"
    answer("derive", robot, "--output", target)
    target.write_text("mine")
    refused = geodesic("derive", robot, "--output", target)
    assert refused.returncode == 1 and "--force" in refused.stderr, refused.stderr
    assert target.read_text() == "mine"
    answer("derive", robot, "--output", target, "--force")
    assert "M11 =" in target.read_text()
    answer("derive", robot, "--format", "matlab", "--output", folder / "m")
    again = geodesic("derive", robot, "--format", "matlab", "--output", folder / "m")
    assert again.returncode == 1 and "M_metric.m" in again.stderr, again.stderr

    found = json.loads(answer("derive", robot, "--symbols", "--json", "--gravity", "0,-9.81,0"))
    assert found["M"][1][1] == "m2*lc2^2 + I2" and found["symbols"]["lc2"]["value"] == 0.2
    for wrong, status, words in [
            (["--what", "M,x"], 1, "christoffel"),
            (["--what", "M", "--format", "c"], 1, "--what"),
            (["--gravity", "1,2"], 1, "x,y,z"),
            (["--format", "fortran"], 2, "matlab"),
            (["--limit", "3"], 1, "--yes")]:
        done = geodesic("derive", robot, *wrong)
        assert done.returncode == status and words in done.stderr and not done.stdout, (wrong, done)
    floating = folder / "ball.urdf"
    floating.write_text(robot.read_text().replace('name="joint2" type="revolute"',
                                                  'name="joint2" type="floating"'))
    done = geodesic("derive", floating)
    assert done.returncode == 1 and "'joint2' is floating" in done.stderr, done
    assert "chart" in done.stderr
    help_text = answer("derive", "--help")
    assert "Examples:" in help_text and "--symbols" in help_text


def main():
    with tempfile.TemporaryDirectory() as scratch:
        for number, (robot, derived, evaluated) in enumerate(ROBOTS):
            folder = pathlib.Path(scratch, str(number))
            folder.mkdir()
            check_c(robot, derived, evaluated, folder)
            check_octave(robot, derived, evaluated, folder)
        check_manners(pathlib.Path(scratch))
    print("C and Octave agree with the mechanism")


if __name__ == "__main__":
    main()

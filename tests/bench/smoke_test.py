#!/usr/bin/env python3
"""The bench still runs and prints sane figures. How large they are is nobody's business here."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path


def check(condition, text):
    if not condition:
        sys.exit(f"tests/bench/run: {text}")


def main():
    here = Path(__file__).parent
    with tempfile.TemporaryDirectory() as folder:
        file, picture = Path(folder) / "figures.json", Path(folder) / "figures.png"
        command = [sys.executable, here / "run", "--quick", "--build", sys.argv[1]]
        command += ["--only", "dynamics", "--json", file, "--plot", picture]
        done = subprocess.run(command, capture_output=True, text=True)
        check(done.returncode == 0, done.stderr)
        figures = json.loads(file.read_text())
        check(picture.read_bytes().startswith(b"\x89PNG"), "the picture is no PNG")
    check("design: bias" in done.stdout, "no verdict against the design's figure")
    robots = {robot["robot"]: robot for robot in figures["dynamics"]}
    check(set(robots) == {"openarm", "iiwa14", "ur5"}, f"other robots: {set(robots)}")
    for robot in robots.values():
        check(not robot["absent"], f"{robot['robot']} without {robot['absent']}")
        for function, timed in robot["ns"].items():
            check({"Geodesic", "KDL", "KDL merged", "MuJoCo"} == set(timed), f"who timed {function}")
            for t in timed.values():
                check(0 < t["min"] <= t["median"] <= t["p90"] < 1e9, f"{function}: {t}")


main()

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
    names = {"planar2r", "ur5", "iiwa14", "openarm", "bimanual", "humanoid"}
    check(set(robots) == names, f"other robots: {set(robots)}")
    for name, robot in robots.items():
        everybody = {"Geodesic", "MuJoCo"}
        if name not in ("bimanual", "humanoid"):  # KDL knows chains on fixed bases
            everybody |= {"KDL", "KDL merged"}
        check(set(robot["ns"]["bias"]) == everybody, f"{name} by {set(robot['ns']['bias'])}")
        check(len(robot["ns"]) == 7 and len(robot["ns_cold"]) == 3, f"functions of {name}")
        for timed in [*robot["ns"].values(), *robot["ns_cold"].values()]:
            for t in timed.values():
                check(0 < t["min"] <= t["median"] <= t["p90"] < 1e9, f"{name}: {t}")


main()

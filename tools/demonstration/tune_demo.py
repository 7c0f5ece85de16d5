#!/usr/bin/python3
"""Shows tuning without a jolt: the arm holds its pose in simulated time while gains and payload change;
draws every cycle's torque and how far it moved from the cycle before."""
import argparse
import csv
import pathlib
import sys
import time

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend must be chosen first)

from programs import Pair, ProgramError  # noqa: E402

RELEASE_S = 1.5
BETWEEN_S = 1.5
COLUMNS = ("command_", "q_")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", type=pathlib.Path, required=True)
    parser.add_argument("--payload", required=True, help="a [[payload]] of the robot's file")
    parser.add_argument("--bus", choices=["vcan", "unix"], default="unix")
    parser.add_argument("--binaries", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder for tune.png")
    return parser.parse_args()


def pass_time(pair, seconds):
    until = pair.status.status()["time_s"] + seconds
    while pair.status.status()["time_s"] < until:
        time.sleep(0.02)


def run(options):
    """Returns the trace's rows and the moments: [(time, words)]."""
    moments = []
    with Pair(options.binaries, options.robot, options.bus, options.out / "tune") as pair:
        pair.sim("--lockstep", "--release", RELEASE_S)
        trace = pair.folder / "daemon.csv"
        daemon = pair.daemon("--simulated-time", "--law", "hold", "--trace", trace,
                             "--trace-hz", 1000)
        pair.wait_for_state("active")
        pass_time(pair, RELEASE_S + 1.5)

        def tune(words, **request):
            answer = pair.status.ask(cmd="tune", **request)
            if not answer["ok"]:
                raise ProgramError(answer["error"])
            moments.append((pair.status.status()["tuning"]["last"]["at_s"], words))
            pass_time(pair, BETWEEN_S)

        joints = [joint["name"] for joint in pair.status.status()["joints"]]
        stiffness = {f"joint.{name}.hold_stiffness": 25 for name in joints if "finger" not in name}
        tune("all hold_stiffness = 25", set=stiffness)
        tune(f"payload = {options.payload}", set={"payload": options.payload})
        tune("--undo (payload)", undo=True)
        tune("--undo (stiffness)", undo=True)
        tune("gravity turned by 3°", set={"robot.gravity": [0.513, 0, -9.797]})
        tune("--undo (gravity)", undo=True)
        daemon.stop()
    with open(trace, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file)), moments


def columns(rows, prefix):
    names = [name for name in rows[0] if name.startswith(prefix)]
    return {name[len(prefix):]: [float(row[name]) for row in rows] for name in names}


def draw(rows, moments, path):
    """@return largest change of a command from one cycle to the next [N·m]"""
    start = moments[0][0] - 0.6
    end = moments[-1][0] + BETWEEN_S - 0.1
    rows = [row for row in rows if start <= float(row["time_s"]) < end]
    times = [float(row["time_s"]) for row in rows]
    command, position = (columns(rows, prefix) for prefix in COLUMNS)
    figure, (top, middle, bottom) = pyplot.subplots(3, 1, figsize=(10, 9), sharex=True)
    largest = 0.0
    for name, values in command.items():
        change = [b - a for a, b in zip(values, values[1:])]
        largest = max(largest, *map(abs, change))
        top.plot(times, values, lw=1.2, label=name)
        middle.plot(times[1:], change, lw=0.7)
        bottom.plot(times, [1000 * (q - position[name][0]) for q in position[name]], lw=1.2)
    for at, words in moments:
        for axes in (top, middle, bottom):
            axes.axvline(at, color="#8a8a8a", lw=0.8, ls=":")
        top.annotate(words, (at, 1.0), xycoords=("data", "axes fraction"), fontsize=8,
                     rotation=20, ha="left", va="bottom")
    top.set_ylabel("torque commanded [N·m or N]")
    middle.set_ylabel("change in one cycle [N·m or N]")
    bottom.set_ylabel("moved [mrad or mm]")
    bottom.set_xlabel("time [s], every cycle drawn")
    top.legend(fontsize=8, ncol=2, frameon=False)
    for axes in (top, middle, bottom):
        axes.grid(alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return largest


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    try:
        rows, moments = run(options)
    except ProgramError as problem:
        print(f"NOT SHOWN: {problem}", file=sys.stderr)
        return 1
    picture = options.out / "tune.png"
    largest = draw(rows, moments, picture)
    print(f"{len(moments)} changes while the arm held its pose; largest change of a torque from one "
          f"cycle to the next: {largest:.4f} N·m\nplot     {picture}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""The demo: the simulated arm floats under the daemon, is pushed, coasts, and stays where it is left;
then the same push without compensation. Prints a live table, a verdict, and where the plot is."""
import argparse
import json
import pathlib
import sys
import time

import motion
import plot
import verdict
from programs import Pair, ProgramError, may_be_realtime

RELEASE_S = 2.0  # the stand lets go this long after the drives were enabled (ramp: 1 s)
PUSH_S = 0.25    # length of the push
CONTRAST_S = 3.0  # how long the arm is watched falling
COLUMNS = "{:<28}{:>12}{:>12}{:>13}{:>13}"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", required=True)
    parser.add_argument("--bus", choices=["vcan", "unix"], required=True)
    parser.add_argument("--bus-reason", default="")
    parser.add_argument("--seconds", type=float, default=16.0)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--binaries", type=pathlib.Path, required=True)
    parser.add_argument("--simulated-time", action="store_true",
                        help="where this machine cannot keep time (user-mode Linux)")
    parser.add_argument("--timing-only", action="store_true",
                        help="only measure the daemon in real time for a few seconds")
    return parser.parse_args()


class Table:
    """Joint, angle, velocity, torque; redrawn in place on a terminal, once a second elsewhere."""

    def __init__(self):
        self.live = sys.stdout.isatty()
        self.rows = 0
        self.next = 0.0

    def show(self, status):
        now = time.monotonic()
        if now < self.next:
            return
        self.next = now + (0.2 if self.live else 4.0)
        lines = [f"{status['state']:<12} law {status['law']:<8} authority {status['authority']:.2f}"
                 f"   cycle {status['cycles']}   missed {status['missed']}",
                 COLUMNS.format("joint", "angle", "velocity", "torque", "model")]
        for joint in status["joints"]:
            lines.append(COLUMNS.format(joint["name"], f"{joint['position']:+.4f}",
                                        f"{joint['velocity']:+.4f}", f"{joint['command']:+.3f}",
                                        f"{joint['model']:+.3f}"))
        if self.live and self.rows:
            print(f"\x1b[{self.rows}A", end="")
        for line in lines:
            print(line + ("\x1b[K" if self.live else ""))
        if not self.live:
            print()
        sys.stdout.flush()
        self.rows = len(lines)


def run(options, name, law, seconds, push_at):
    """One run of the pair; returns the true motion and both summaries."""
    folder = options.out / name
    wrench = push_wrench(options, push_at)
    with Pair(options.binaries, options.robot, options.bus, folder) as pair:
        pair.sim("--release", RELEASE_S, "--trace", folder / "truth.csv", "--wrench", wrench,
                 *(["--lockstep"] if options.simulated_time else []))
        extra = ["--simulated-time"] if options.simulated_time else realtime_arguments()
        more = ["--allow-zero-law"] if law == "zero" else []
        daemon = pair.daemon("--law", law, "--seconds", RELEASE_S + seconds, "--exit-on-fault",
                             "--trace", folder / "daemon.csv", *extra, *more)
        table = Table()
        while daemon.running():
            try:
                table.show(pair.status.status())
            except (OSError, ValueError):
                pass
            time.sleep(0.1)
        exit_status = daemon.wait()
        pair.close()
        if not (folder / "daemon.json").exists() or not (folder / "sim.json").exists():
            raise ProgramError(f"a run left no summary (daemon: status {exit_status})\n"
                               f"{pair.logs()}")
        return {"truth": motion.read(folder / "truth.csv"), "daemon": pair.summary("daemon"),
                "sim": pair.summary("sim"), "exit_status": exit_status, "folder": str(folder)}


def realtime_arguments():
    return [] if may_be_realtime() else ["--best-effort"]


def measure_timing(options):
    """The daemon in real time on the socket bus: where the float runs on simulated time, its
    latencies come from here. Leaves timing.json."""
    folder = options.out / "timing"
    with Pair(options.binaries, options.robot, "unix", folder) as pair:
        pair.sim("--release", 1000)
        pair.daemon("--seconds", 5, "--exit-on-fault", *realtime_arguments()).wait()
        timing = pair.summary("daemon")
    (options.out / "timing.json").write_text(json.dumps(timing, indent=2) + "\n",
                                             encoding="utf-8")


def push_wrench(options, at):
    """A push at the tool that most arms feel and few are thrown by."""
    import tomllib
    with open(options.robot, "rb") as file:
        robot = tomllib.load(file)
    demo_force = (4.0, 3.0, 2.0)
    return f"{robot['robot']['tool_link']}:{','.join(map(str, demo_force))}@{at}+{PUSH_S}"


def main():
    options = arguments()
    options.out.mkdir(parents=True, exist_ok=True)
    if options.timing_only:
        measure_timing(options)
        return 0
    push_at = max(1.0, options.seconds * 0.25)
    try:
        print(f"\n1. Compensation on (law float): held, pushed at {push_at:.1f} s, left alone.\n")
        floating = run(options, "float", "float", options.seconds, push_at)
        print("\n2. The same push with compensation off (law zero), for contrast.\n")
        falling = run(options, "zero", "zero", CONTRAST_S, 1.0)
    except ProgramError as problem:
        print(f"\nNOT SHOWN: {problem}", file=sys.stderr)
        return 1
    result = verdict.judge(floating, falling, push_at, PUSH_S, options.seconds)
    result["bus"] = {"kind": options.bus, "why": options.bus_reason}
    timing = options.out / "timing.json"
    if options.simulated_time and timing.exists():
        result["timing"] = json.loads(timing.read_text(encoding="utf-8"))
        result["timing_from"] = "real time, socket bus, this kernel, 5 s"
    summary = options.out / "summary.json"
    summary.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    picture = options.out / "float.png"
    plot.draw(floating, falling, result, picture)
    verdict.show(result)
    print(f"\nplot     {picture}\nsummary  {summary}\n"
          f"logs     {floating['folder']}, {falling['folder']}")
    print("\nTHE ARM FLOATS" if result["floats"] else "\nTHE ARM DID NOT FLOAT")
    return 0 if result["floats"] else 1


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""What `geodesic check` says of a cycle on the wire: table, JSON and picture, held against each other
and against the arithmetic. Arguments: the program, the source folder."""
import json
import pathlib
import subprocess
import sys
import tempfile

GEODESIC, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
ROBOT = SOURCE / "config/robots/openarm-bimanual/robot.toml"


def expect(condition, text):
    if not condition:
        sys.exit(f"geodesic check: {text}")


def check(*words):
    done = subprocess.run([GEODESIC, "check", ROBOT, *words], capture_output=True, text=True)
    expect(done.returncode == 0, done.stderr)
    return done.stdout


def see_timeline(bus):
    line = bus["timeline"]
    frames = line["frames"]
    expect(len(frames) == bus["frames"] == 16, f"{len(frames)} frames")
    expect(sorted(line["order"]) == sorted({frame["joint"] for frame in frames}), "the order")
    end = 0.0
    for frame in frames:  # in order of time, one after the other
        expect(frame["start_us"] >= end - 1e-6, f"{frame} begins before {end}")
        end = frame["end_us"]
        expect(0.0 < frame["best_end_us"] <= end, f"{frame}: stuff bits make it earlier")
        if frame["reply"]:
            expect(abs(frame["slack_us"] - (line["deadline_us"] - end)) < 1e-6, f"slack of {frame}")
            asked = [f for f in frames if f["joint"] == frame["joint"] and not f["reply"]]
            expect(frame["ready_us"] >= asked[0]["end_us"] + line["latency_us"] - 1e-6,
                   f"{frame} answers before it was asked")
    expect(abs(line["end_us"] - end) < 1e-6 and line["idle_us"] < 1e-6, "the wire idles")
    expect(abs(line["busy_us"] - 16 * 56.6) < 1e-6, f"busy for {line['busy_us']} us")
    expect(abs(line["headroom_us"] - (1000.0 - end)) < 1e-6, "headroom")
    expect(line["reachable_hz"] >= 0.95 * line["limit_hz"] and line["collisions"] == 0, "the rate")


def main():
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "cycle.png"
        text = check("--plot", picture)
        expect(picture.read_bytes().startswith(b"\x89PNG"), "the picture is no PNG")
        missing = pathlib.Path(folder) / "none" / "cycle.png"
        done = subprocess.run([GEODESIC, "check", ROBOT, "--plot", missing], capture_output=True,
                              text=True)
        expect(done.returncode == 1 and str(missing) in done.stderr, done.stderr)
    answer = json.loads(check("--json"))
    expect(len(answer["buses"]) == 2, "two buses")
    for bus in answer["buses"]:
        see_timeline(bus)
        expect(f"a cycle on bus {bus['name']}, at worst:" in text, f"no table of {bus['name']}")
        line = bus["timeline"]
        expect(f"the last reply ends at {line['end_us']:.1f} us" in text and
               f"{line['slack_us']:.1f} us of slack" in text and
               f"{line['headroom_us']:.1f} us (9.4 %) of headroom" in text, text)
    for frame in answer["buses"][0]["timeline"]["frames"]:
        expect(any(frame["joint"] in row and f"{frame['end_us']:.1f}" in row
                   for row in text.splitlines()), f"{frame} is not in the table")


main()

#!/usr/bin/python3
"""The rate that each drive family and each robot that has to hold one reaches, against what bit
timing allows. In made-up time, so alike on every machine: our drivers and simulated drives on a wire
modelled bit for bit (wire_rate.cpp). Ends with 1 if a reply was lost or late. `run` does the
same in real time."""
import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/system"))
import families  # noqa: E402

ROBOTS = ROOT / "config/robots"
# Robots that have to hold a rate, and which.
HELD = {"openarm-bimanual": 1000, "quad12": 1000}
DRIVES = 7
USABLE = 0.95  # of what bit timing allows (kUsableBus)
CYCLES = 1000
PATIENCE_S = 120
LINK = """<link name="link{i}"><inertial><mass value="{mass}"/><origin xyz="0.05 0 0"/>
  <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial></link>
<joint name="joint{i}" type="revolute"><parent link="{parent}"/><child link="link{i}"/>
  <origin xyz="{x} 0 0"/><axis xyz="0 {y} {z}"/>
  <limit lower="-3.0" upper="3.0" effort="100" velocity="10"/></joint>
"""
TOML = """[robot]
name = "{name}"
urdf = "robot.urdf"
rate_hz = {rate}

[realtime]
receive_deadline = 0.98

[[bus]]
name = "arm"
interface = "can0"
{bus}
[defaults.joint]
bus = "arm"
drive = {drive}
torque_limit = {torque}
torque_rate_limit = 1000
hold_damping = 0.5
stop_damping = 0.5
drive_damping = 0.5
rotor_inertia = 0.012

[control]
law = "float"
start_active = true

"""


def chain(joints):
    links = "".join(
        LINK.format(i=i, mass=0.2, parent=f"link{i - 1}" if i > 1 else "base", x=0.1 if i > 1 else 0,
                    y=i % 2, z=1 - i % 2) for i in range(1, joints + 1))
    return f'<?xml version="1.0"?>\n<robot name="chain"><link name="base"/>\n{links}</robot>\n'


def write(folder, name, family, rate):
    """A chain of DRIVES joints driven by that family. @return its robot.toml"""
    folder.mkdir(exist_ok=True)
    (folder / "robot.urdf").write_text(chain(DRIVES))
    bus = "".join(f"{key} = {families.value(of)}\n" for key, of in family["bus"].items())
    text = TOML.format(name=name, rate=rate, bus=bus, drive=families.inline(family["default"]),
                       torque=family.get("torque_limit", 30.0))
    for i in range(DRIVES):
        drive = {}
        for key, first in family["joint1"].items():
            second = family["joint2"].get(key, first)
            counts = isinstance(first, int) and not isinstance(first, bool)
            drive[key] = first + i * (second - first) if counts else first
        text += f'[[joint]]\nname = "joint{i + 1}"\ndrive = {families.inline(drive)}\n\n'
    (folder / "robot.toml").write_text(text)
    return folder / "robot.toml"


def check(build, robot):
    done = subprocess.run([build / "tools/geodesic", "check", robot, "--json"], capture_output=True,
                          text=True)
    answer = json.loads(done.stdout or "{}")
    if "buses" not in answer:
        sys.exit(f"geodesic check {robot}:\n{done.stderr}")
    return answer


def at_the_limit(build, folder, name, family):
    """The family's chain at USABLE of its limit, which depends on the rate where drives report by
    their own timers."""
    rate = 100.0
    for _ in range(12):
        robot = write(folder, name, family, rate)
        limit = check(build, robot)["buses"][0]["timeline"]["limit_hz"]
        before, rate = rate, int(100 * min(USABLE * limit, 4000)) / 100
        if abs(rate - before) < 0.02:
            break
    return write(folder, name, family, min(before, rate))


def slow_classic(folder):
    """Seven Damiao joints on one classic bus, 500 Hz."""
    return write(folder, "seven-damiao-500", families.load()["damiao"], 500.0)


def robots(build, scratch, only=None):
    """Name and robot.toml of each: all families at their limit, and those that have to hold a rate."""
    wanted = [*families.load(), "seven-damiao-500", *HELD]
    if unknown := set(only or []) - set(wanted):
        sys.exit(f"--only {' '.join(unknown)}: expected one of {' '.join(wanted)}")
    wanted = only or wanted
    all_of = {name: at_the_limit(build, scratch / name, name, family)
              for name, family in families.load().items() if name in wanted}
    if "seven-damiao-500" in wanted:
        all_of["seven-damiao-500"] = slow_classic(scratch / "seven-damiao-500")
    all_of |= {name: ROBOTS / name / "robot.toml" for name in HELD if name in wanted}
    return all_of


def row(build, name, robot, measured):
    """One robot's figures, of its fullest bus, with what is wrong."""
    checked = check(build, robot)
    wrong = [] if measured["holds"] else [measured.get("why", "replies lost or late")]
    if "buses" not in measured:
        return {"name": name, "wrong": wrong}
    worst = max(measured["buses"], key=lambda bus: bus["busy_us"])
    for bus, told in zip(measured["buses"], checked["buses"]):
        if not bus["busy_best_us"] <= bus["busy_us"] + 1.0 <= bus["busy_worst_us"] + 2.0:
            wrong.append(f"bus {bus['bus']} is busy for {bus['busy_us']:.1f} us a cycle, the family "
                         f"says {bus['busy_best_us']:.1f} to {bus['busy_worst_us']:.1f}")
        if bus["bound_us"] and bus["latest_reply_us"] > bus["bound_us"]:
            wrong.append(f"bus {bus['bus']}: a reply at {bus['latest_reply_us']:.1f} us, after the "
                         f"model's bound")
        if told["timeline"]["collisions"]:
            wrong.append(f"bus {bus['bus']}: replies collide")
    share = measured["rate_hz"] / worst["limit_hz"]
    if name not in HELD and name != "seven-damiao-500" and share < USABLE - 1e-4 and \
            measured["rate_hz"] < 3999:
        wrong.append(f"{100 * share:.1f} % of the limit")
    if measured["rate_hz"] < HELD.get(name, 0):
        wrong.append(f"it has to hold {HELD[name]} Hz")
    return {"name": name, "fd": checked["buses"][0]["fd"], "buses": len(checked["buses"]),
            "drives": len(checked["joints"]), "rate_hz": measured["rate_hz"], "share": share,
            "limit_hz": worst["limit_hz"], "frames": worst["frames_a_cycle"],
            "busy_us": worst["busy_us"], "last_reply_us": worst["last_reply_us"],
            "latest_reply_us": worst["latest_reply_us"], "deadline_us": worst["deadline_us"],
            "reply_gap_us": worst["reply_gap_us"], "lost": measured["lost"], "wrong": wrong}


def measure(build, scratch, only=None):
    all_of = robots(build, scratch, only)
    rows = []
    for name, robot in all_of.items():
        command = [build / "tests/bench/wire_rate", str(CYCLES), robot]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:  # every reply that is missing is waited for a second
            rows.append({"name": name, "wrong": ["replies are missing again and again"]})
            continue
        if not done.stdout:
            sys.exit(f"wire_rate {robot}:\n{done.stderr}")
        rows.append(row(build, name, robot, json.loads(done.stdout)[0]))
    return rows


def show(rows):
    print("\nRates in made-up time, a wire modelled bit for bit, drives answering in 100 us")
    print(f"  {'':<18} {'bus':<9}{'drives':>7}{'limit Hz':>10}{'ran Hz':>9}{'share':>8}"
          f"{'busy us':>9}{'last us':>9}{'latest':>9}{'deadline':>9}{'gap':>7}{'lost':>6}")
    for r in rows:
        if "rate_hz" in r:
            kind = ("FD" if r["fd"] else "classic") + (f" x{r['buses']}" if r["buses"] > 1 else "")
            print(f"  {r['name']:<18} {kind:<9}{r['drives']:>7}{r['limit_hz']:>10.1f}"
                  f"{r['rate_hz']:>9.1f}{100 * r['share']:>7.1f}%{r['busy_us']:>9.1f}"
                  f"{r['last_reply_us']:>9.1f}{r['latest_reply_us']:>9.1f}{r['deadline_us']:>9.1f}"
                  f"{r['reply_gap_us']:>7.1f}{r['lost']:>6}  {'; '.join(r['wrong']) or 'holds'}")
        else:
            print(f"  {r['name']:<18} {'; '.join(r['wrong'])}")
    print("  (limit: as many stuff bits as there can be; busy, last: mean of the fullest bus; times "
          "since the cycle began)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", type=Path, default=ROOT / "build/default")
    parser.add_argument("--only", action="append", metavar="NAME", help="a family's table or a robot")
    parser.add_argument("--json", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="geodesic-rates-") as scratch:
        rows = measure(arguments.build, Path(scratch), arguments.only)
    show(rows)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")
    if any(r["wrong"] for r in rows):
        sys.exit("a rate does not hold")


if __name__ == "__main__":
    main()

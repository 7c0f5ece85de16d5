"""Plays faults.toml: each row on this kind of bus is one test. What happened is kept as JSON for
fault_matrix.py."""
import fcntl
import functools
import json
import os
import pathlib
import subprocess
import time

import fault_checks
import fault_rows
import pytest
from fault_means import Candump, Means, OutOfShape, SocketBus
from programs import Pair, Program, may_be_realtime

ROWS = fault_rows.load()
ATTEMPTS = 3
F_SETPIPE_SZ = 1031


@functools.cache
def own_machine():
    return "User Mode Linux" in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")


def kind_of_bus(config):
    if config.getoption("--bus") != "vcan":
        return config.getoption("--bus")
    echo = pathlib.Path("/sys/module/vcan/parameters/echo")
    return "vcan-echo" if echo.exists() and echo.read_text().strip() in "Y1" else "vcan"


def pytest_generate_tests(metafunc):
    if "row" in metafunc.fixturenames:
        kind = kind_of_bus(metafunc.config)
        here = [r for r in ROWS if fault_rows.reason_not_here(r, kind, own_machine()) is None]
        metafunc.parametrize("row", here, ids=[f"{r['time']}-{r['name']}" for r in here])


class Stand:
    """Daemon and simulated arm for one row, started; the row's wishes for output fulfilled."""

    def __init__(self, row, kind, binaries, folder):
        self.row, self.kind, self.folder = row, kind, folder
        folder.mkdir(parents=True)
        self.robot = fault_rows.write_robot(row, folder)
        self.pair = Pair(binaries, self.robot, kind.removesuffix("-echo"), folder)
        self.real = row["time"] == "real"
        self.disk = folder
        self.log_pipe = self.listener = self.sim = self.daemon = None
        self.piped = b""
        if row.get("output") == "tmpfs":
            self.disk = folder / "disk"
            self.disk.mkdir()
            shell(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(self.disk)])

    def start(self):
        row = self.row
        script = fault_rows.of_kind(row.get("script", []), self.kind) or []
        arguments = [*row["sim"], *[a for text in script for a in ("--fault", text)],
                     *[a for text in row.get("push", []) for a in ("--push", text)]]
        drives = self.pair
        if "drives_on" in row:
            drives = Pair(self.pair.binaries, self.robot, "vcan", self.folder)
            drives.drives_on = ["--bus", row["drives_on"]]
        self.sim = drives.sim(*arguments)
        if row.get("command_age"):
            bus = self.pair.bus_arguments[1]
            self.listener = SocketBus(bus) if self.kind == "unix" else Candump(bus, self.folder)
        self.start_daemon()

    def start_daemon(self):
        pair, rate = self.pair, self.row["options"].get("robot", {}).get("rate_hz", 1000)
        best_effort = [] if not self.real or may_be_realtime() else ["--best-effort"]
        command = [pair.binaries / "geodesicd", self.robot, *pair.bus_arguments, "--socket",
                   pair.socket, "--summary", self.disk / "daemon.json", "--trace",
                   self.disk / "daemon.csv", "--trace-hz", rate, *self.row["daemon"], *best_effort]
        self.daemon = DaemonProgram(command, self.folder, self.row.get("output"))
        self.log_pipe = self.daemon.pipe
        pair.started.append(self.daemon)

    def wait_until_active(self):
        end = time.monotonic() + 20
        while time.monotonic() < end and self.daemon.running():
            try:
                if self.pair.status.status()["state"] == "active":
                    return
            except (OSError, ValueError):
                pass
            time.sleep(0.02)
        raise OutOfShape(f"not active before anything went wrong:\n{self.log()}")

    def blame_the_machine(self, problem):
        """On a shared machine's own clock one failure shows nothing: the machine may have kept the
        loop, the arm or the wire from running. What fails at every attempt fails."""
        summary = self.disk / "daemon.json"
        if not self.real or not summary.exists():
            return
        missed = json.loads(summary.read_text(encoding="utf-8") or "{}").get("missed", 0)
        raise OutOfShape(f"{missed} cycles missed; {problem}") from problem

    def read_pipe(self):
        """What the log's pipe holds, as its reader would have read it."""
        try:
            while part := os.read(self.log_pipe, 1 << 16):
                self.piped += part
        except (BlockingIOError, TypeError):
            pass

    def log(self):
        if self.row.get("output") == "pipe":
            self.read_pipe()
            return self.piped.decode(errors="replace")
        return self.daemon.output()

    def close(self):
        self.pair.close()
        if self.sim is not None and self.sim.running():
            self.sim.kill()
        if self.disk != self.folder:
            shell(["umount", str(self.disk)])


class DaemonProgram(Program):
    """The daemon with its log where the row wants it; stderr apart."""

    def __init__(self, command, folder, output):  # pylint: disable=super-init-not-called
        self.arguments = [str(a) for a in command]
        self.log = folder / "daemon.log"
        self.errors = folder / "daemon.err"
        self.pipe = None
        if output == "pipe":
            self.pipe, write = os.pipe()
            fcntl.fcntl(write, F_SETPIPE_SZ, 4096)
            os.set_blocking(self.pipe, False)
            self.log.touch()
        else:
            write = os.open("/dev/full" if output == "/dev/full" else self.log,
                            os.O_WRONLY | os.O_CREAT | os.O_APPEND)
            self.log.touch()
        with open(self.errors, "a", encoding="utf-8") as errors:
            self.process = subprocess.Popen(self.arguments, stdin=subprocess.DEVNULL, stdout=write,
                                            stderr=errors)
        os.close(write)


def shell(command):
    subprocess.run(command, check=True, capture_output=True, timeout=20)


def test_every_row_is_complete():
    """Loading has checked each: named, something goes wrong, something is expected, and a reason
    stands for every kind of bus it does not run on. And a row without expectation is refused."""
    assert len(ROWS) > 30
    with pytest.raises(ValueError, match="nothing is said of fault"):
        fault_rows.check({"name": "x", "what": "y", "time": "real"}, {})
    good = dict(ROWS[0])
    with pytest.raises(ValueError, match="nothing goes wrong"):
        fault_rows.check(good, {})
    with pytest.raises(ValueError, match="why not on"):
        fault_rows.check({**good, "not_on": {}}, {"script": ["x"]})


def test_fault(request, row, binaries, tmp_path):
    kind = kind_of_bus(request.config)
    result = {"row": row["name"], "bus": kind, "passed": False}
    began = time.monotonic()
    try:
        for attempt in range(ATTEMPTS):
            try:
                result.update(play(row, kind, binaries, tmp_path / str(attempt)))
                break
            except OutOfShape as problem:
                result["problem"] = str(problem)
        else:
            pytest.fail(f"{ATTEMPTS} attempts: {result['problem']}")
        result["passed"] = True
    finally:
        result["seconds"] = round(time.monotonic() - began, 1)
        keep(binaries, result)


def play(row, kind, binaries, folder):
    stand = Stand(row, kind, binaries, folder)
    means = Means(stand)
    try:
        for command in row.get("before", []):
            means.do_run({"run": command})
        stand.start()
        if stand.real:
            stand.wait_until_active()
            time.sleep(0.6)  # the ramp is over, and the stand has let go
        means.play(fault_rows.of_kind(row.get("inject", []), kind) or [])
        try:
            return judge(row, kind, stand, means)
        except AssertionError as problem:
            stand.blame_the_machine(problem)
            raise
    finally:
        means.close()
        stand.close()
        for command in fault_rows.of_kind(row.get("undo", []), kind) or []:
            subprocess.run(command.split(), check=False, capture_output=True)


def judge(row, kind, stand, means):
    expected = fault_rows.of_kind(row["fault"], kind)
    killed = row.get("final_state") == "killed"
    carries_on = expected == "none" or row["class"] == "warn" if not killed else False
    if killed:
        time.sleep(0.4)
    else:
        if stand.real and (carries_on or row.get("stays")):
            assert stand.daemon.running(), stand.log()
            stand.daemon.send(15)
        status = stand.daemon.wait(60)
        wanted = row.get("exit", 0 if row["final_state"] == "off" else 3)
        assert status == wanted, f"exit {status}, not {wanted}\n{stand.log()}"
    arrivals = stand.listener.close() if stand.listener else []
    if stand.sim.running():
        stand.sim.stop()
    truth = None if row.get("drives_gone") else stand.pair.summary("sim")
    if truth:
        fault_checks.at_the_drives(row, truth)
    if killed:
        off_ns = truth["start_ns"] + round(truth["disabled_at_s"] * fault_checks.NS)
        return timely(row, off_ns, means.began_ns, means.ended_ns, 5_000_000)
    if row.get("stderr"):
        errors = stand.daemon.errors.read_text(encoding="utf-8")
        fault_checks.log({"log": row["stderr"]}, "none", [], errors)
        fault_checks.log(row, expected, [], stand.log())
        return {}
    summary = json.loads((stand.disk / "daemon.json").read_text(encoding="utf-8"))
    trace = fault_checks.daemon_trace(stand.disk / "daemon.csv")
    named = fault_checks.faults(row, expected, summary)
    assert summary["final_state"] == row["final_state"]
    if row.get("output") != "/dev/full":
        fault_checks.log(row, expected, named, stand.log())
    fault_checks.torque_only_where_it_may_be(trace)
    fault_checks.reached(row, trace)
    fault_checks.counters(row, summary)
    result = {}
    if row.get("command_age"):
        commands = [frame for frame in arrivals if frame[1] < 0x10 or frame[1] == 0x7FF]
        oldest = fault_checks.command_age(row, trace, summary, commands)
        result["oldest_command_ms"] = round(oldest * 1e-6, 1)
    if expected != "none":
        event_ns = round(min(entry["time"] for entry in named) * fault_checks.NS)
        period_ns = summary["period_ns"]
        if not stand.real:
            assert abs(summary["cycles"] - truth["lockstep_sets"]) <= 3
            injected_ns = round(injected_s(row, truth) * fault_checks.NS)
            result |= timely(row, event_ns, injected_ns, injected_ns, period_ns)
        else:
            event_ns += summary["first_tick_ns"]
            scripted = truth["injections"] if truth else []
            began, ended = means.began_ns, means.ended_ns
            if scripted:
                began = ended = scripted[0]["at_ns"]
            elif any("start" in step for step in row["inject"]):
                began = ended = summary["first_tick_ns"]
            result |= timely(row, event_ns, began, ended, period_ns)
    return result


def injected_s(row, truth):
    """When the simulated arm did it, since its start."""
    if truth["injections"]:
        return truth["injections"][0]["at_s"]
    return truth["release_at_s"] + float(row["push"][0].split("@")[1].split("+")[0])


def timely(row, event_ns, began_ns, ended_ns, period_ns):
    """Cycles from the injection to the event. An injection that takes time of its own has its
    effect before its end."""
    cycles = max(0, -((ended_ns - event_ns) // period_ns))
    assert event_ns >= began_ns - period_ns, "the fault came before its cause"
    assert cycles <= row["within_cycles"], f"{cycles} cycles, not {row['within_cycles']}"
    return {"cycles": cycles, "cycles_at_most": max(0, -((began_ns - event_ns) // period_ns))}


def keep(binaries, result):
    folder = binaries.parent / "fault_matrix"
    folder.mkdir(exist_ok=True)
    path = folder / f"{result['row']}.{result['bus']}.json"
    path.write_text(json.dumps(result) + "\n", encoding="utf-8")

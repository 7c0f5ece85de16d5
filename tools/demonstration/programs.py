"""Starts the daemon and the simulated arm as processes, waits for what they say, asks the daemon
for its status, and ends them. Used by the demo and by the system tests."""
import json
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import time


class ProgramError(RuntimeError):
    """A program did not do what was expected of it; the text carries its own last words."""


class Program:
    """One running process with its output in a file, so that no pipe can fill up and block it."""

    def __init__(self, arguments, log):
        self.arguments = [str(a) for a in arguments]
        self.log = pathlib.Path(log)
        with open(self.log, "w", encoding="utf-8") as out:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                self.arguments, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT)

    @property
    def name(self):
        return pathlib.Path(self.arguments[0]).name

    def output(self):
        return self.log.read_text(encoding="utf-8", errors="replace")

    def running(self):
        return self.process.poll() is None

    def wait_for(self, text, seconds=20.0):
        """Returns once the output contains `text`."""
        end = time.monotonic() + seconds
        while text not in self.output():
            if not self.running():
                raise ProgramError(f"{self.name} ended with status {self.process.returncode} "
                                   f"before it said '{text}':\n{self.output()}")
            if time.monotonic() > end:
                raise ProgramError(f"{self.name} did not say '{text}' in {seconds} s:\n"
                                   f"{self.output()}")
            time.sleep(0.02)

    def wait(self, seconds=60.0):
        """Returns the exit status; ends the process if it does not end by itself in time."""
        try:
            return self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()
            raise ProgramError(f"{self.name} still ran after {seconds} s:\n"
                               f"{self.output()}") from None

    def send(self, number):
        if self.running():
            self.process.send_signal(number)

    def stop(self, seconds=60.0):
        """Asks it to end (SIGTERM) and returns the exit status."""
        self.send(signal.SIGTERM)
        return self.wait(seconds)

    def kill(self):
        if self.running():
            self.process.kill()
        self.process.wait()


class Status:
    """A line to the daemon's control socket."""

    def __init__(self, path):
        self.path = str(path)

    def ask(self, **request):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
            line.settimeout(5.0)
            line.connect(self.path)
            line.sendall(json.dumps(request).encode() + b"\n")
            answer = b""
            while not answer.endswith(b"\n"):
                part = line.recv(65536)
                if not part:
                    break
                answer += part
        return json.loads(answer)

    def status(self):
        return self.ask(cmd="status")


class Pair:
    """The simulated arm and the daemon for one robot file on one kind of bus: unix, vcan, or kvaser
    (two cards on one wire, the daemon on can0, the drives on can1)."""

    def __init__(self, binaries, robot, bus, folder=None):
        self.binaries = pathlib.Path(binaries)
        self.robot = pathlib.Path(robot)
        self.folder = pathlib.Path(folder or tempfile.mkdtemp(prefix="geodesic-"))
        self.folder.mkdir(parents=True, exist_ok=True)
        self.bus_arguments = []
        for index in range(bus_count(self.robot)):
            name = {"vcan": f"vcan{index}", "kvaser": "can0"}.get(
                bus, f"unix:{self.folder}/bus{index}")
            self.bus_arguments += ["--bus", name]
        self.drives_on = ["--bus", "can1"] if bus == "kvaser" else self.bus_arguments
        self.socket = self.folder / "daemon.sock"
        self.status = Status(self.socket)
        self.started = []

    def sim(self, *arguments):
        program = Program([self.binaries / "geodesic", "sim", self.robot, *self.drives_on,
                           "--summary", self.folder / "sim.json", *arguments],
                          self.folder / "sim.log")
        self.started.append(program)
        program.wait_for("answering on")
        return program

    def daemon(self, *arguments):
        program = Program([self.binaries / "geodesicd", self.robot, *self.bus_arguments,
                           "--socket", self.socket, "--summary", self.folder / "daemon.json",
                           *arguments], self.folder / "daemon.log")
        self.started.append(program)
        return program

    def wait_for_state(self, state, seconds=20.0):
        """Returns the daemon's status once it is in `state`."""
        end = time.monotonic() + seconds
        last = None
        while time.monotonic() < end:
            try:
                last = self.status.status()
                if last["state"] == state:
                    return last
            except (OSError, ValueError):
                pass
            time.sleep(0.05)
        raise ProgramError(f"the daemon was not '{state}' within {seconds} s; last: "
                           f"{last and last['state']}\n{self.logs()}")

    def summary(self, which):
        return json.loads((self.folder / f"{which}.json").read_text(encoding="utf-8"))

    def logs(self):
        return "\n".join(f"--- {p.name}\n{p.output()}" for p in self.started)

    def close(self):
        for program in reversed(self.started):
            if program.running():
                program.send(signal.SIGTERM)
        for program in self.started:
            try:
                program.process.wait(10)
            except subprocess.TimeoutExpired:
                program.kill()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def bus_count(robot):
    """Buses that a robot file names; the file itself is checked by the programs, not here."""
    import tomllib  # Python 3.11, as in Debian 12 and Ubuntu 24.04
    with open(robot, "rb") as file:
        return max(1, len(tomllib.load(file).get("bus", [])))


def may_be_realtime():
    """Whether this user may ask for SCHED_FIFO here."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        return True
    except OSError:
        return False

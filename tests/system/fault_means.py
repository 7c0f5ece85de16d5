"""How things go wrong on purpose: one function a step that faults.toml names. Where a step takes
time of its own (a shell command), its effect begins somewhere between start and end."""
import os
import pathlib
import shlex
import signal
import socket
import struct
import subprocess
import threading
import time

MAGIC = 0x31424447  # a message of the socket bus: header, then 16 bytes and the data of each frame


class OutOfShape(RuntimeError):
    """This machine did not do what was asked of it in time: the row has to be tried again."""


class SocketBus:
    """A plain client of the socket bus: sends a frame, keeps stamp and identifier of all others."""

    def __init__(self, path):
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.line.connect(str(path).removeprefix("unix:"))
        self.frames = []
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        while message := self.line.recv(1 << 16):
            count, at = struct.unpack_from("<IHHQ", message)[1], 16
            for _ in range(count):
                stamp, identifier, length, flags = struct.unpack_from("<qIBB", message, at)
                at += 16 + (0 if flags & 16 else length)
                self.frames.append((stamp, identifier))

    def send(self, identifier, data, error=False):
        frame = struct.pack("<qIBBH", 0, identifier, len(data), 8 | 1 if error else 0, 0) + data
        self.line.send(struct.pack("<IHHQ", MAGIC, 1, 0, 0) + frame)

    def close(self):
        self.line.close()
        return self.frames


class Candump:
    """The frames that left a vcan's queue, by the kernel's own stamps."""

    def __init__(self, interface, folder):
        self.log = pathlib.Path(folder, "candump.log")
        with open(self.log, "w", encoding="ascii") as out:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                ["candump", "-D", "-L", interface], stdout=out)  # -D: stays when it goes down

    def close(self):
        time.sleep(0.1)
        self.process.terminate()
        self.process.wait(10)
        monotonic_less_real = time.monotonic_ns() - time.time_ns()
        frames = []
        for line in self.log.read_text(encoding="ascii").splitlines():
            stamp, _, frame = line.split()[:3]
            seconds, micros = stamp.strip("()").split(".")
            frames.append((int(seconds) * 10**9 + int(micros) * 1000 + monotonic_less_real,
                           int(frame.split("#")[0], 16)))
        return frames


class Means:
    """Carries out the steps of one row on a running stand (test_fault_matrix.Stand)."""

    def __init__(self, stand):
        self.stand = stand
        self.began_ns = self.ended_ns = None
        self.others = []

    def play(self, steps):
        for step in steps:
            verb = next(iter(step))
            began = time.monotonic_ns()
            getattr(self, "do_" + verb)(step)
            if self.began_ns is None and verb != "wait":
                self.began_ns, self.ended_ns = began, time.monotonic_ns()

    def close(self):
        for other in self.others:
            other.kill()
            other.wait()

    def do_wait(self, step):
        time.sleep(step["wait"])

    def do_run(self, step):
        done = subprocess.run(shlex.split(step["run"]), capture_output=True, text=True, timeout=20,
                              check=False)
        assert done.returncode == 0, f"{step['run']}: {done.stderr}"

    def do_spawn(self, step):
        self.others.append(subprocess.Popen(shlex.split(step["spawn"]), stdout=subprocess.DEVNULL,
                                            stderr=subprocess.DEVNULL))

    def do_signal(self, step):
        program = getattr(self.stand, step["to"])
        began = time.monotonic_ns()
        program.send(getattr(signal, step["signal"]))
        if "for_s" not in step:
            return
        time.sleep(step["for_s"])
        program.send(signal.SIGCONT)
        took = (time.monotonic_ns() - began) * 1e-9
        if took > 2.5 * step["for_s"]:
            raise OutOfShape(f"stopped for {took:.3f} s instead of {step['for_s']} s")

    def do_start(self, step):
        assert step["start"] == "daemon"
        self.stand.daemon.wait(10)
        self.stand.start_daemon()

    def do_clock_step_s(self, step):
        time.clock_settime(time.CLOCK_REALTIME,
                           time.clock_gettime(time.CLOCK_REALTIME) + step["clock_step_s"])

    def do_fill(self, _step):
        with open(self.stand.disk / "filler", "wb", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(512))
            except OSError:
                pass

    def do_close_log(self, _step):
        os.close(self.stand.log_pipe)
        self.stand.log_pipe = None

    def do_read_log(self, _step):
        self.stand.read_pipe()

    def do_requests(self, step):
        for _ in range(step["requests"]):
            assert self.stand.pair.status.status()["ok"]

    def do_remove(self, step):
        for name in step["remove"]:
            (self.stand.robot.parent / name).unlink()

    def do_send(self, step):
        interface = self.stand.pair.bus_arguments[1]
        if not interface.startswith("unix:"):
            self.do_run({"run": f"cansend {interface} {step['send']}"})
            return
        identifier, data = step["send"].split("#")
        number = int(identifier, 16)
        line = SocketBus(interface)
        line.send(number & 0x1FFFFFFF, bytes.fromhex(data), bool(number & 0x20000000))
        time.sleep(0.05)
        line.close()

    def do_second_sim(self, step):
        pair = self.stand.pair
        log = open(pair.folder / "second.log", "w", encoding="utf-8")
        with log:
            self.others.append(subprocess.Popen(
                [pair.binaries / "geodesic", "sim", self.stand.robot, *pair.bus_arguments,
                 *step["second_sim"]], stdout=log, stderr=log))
        end = time.monotonic() + 10
        while "answering" not in (pair.folder / "second.log").read_text(encoding="utf-8"):
            assert time.monotonic() < end, "the second simulator does not start"
            time.sleep(0.005)

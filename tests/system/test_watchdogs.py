"""The chain of watchdogs: the drive watches the daemon, the daemon each drive, the service thread
the real-time thread, the service manager the service thread. Each link is tested by breaking it."""
import fcntl
import os
import select
import signal
import socket
import subprocess
import time

import pytest
from programs import Program
from test_faults import RELEASE_S, unhurried  # noqa: F401  pylint: disable=unused-import
from threads import EXIT, Stopped

WATCHDOG_S = 0.5
REALTIME, SERVICE = "geodesic-rt", "geodesic-svc"


class Manager:
    """What systemd does for a unit with Type=notify, WatchdogSec= and WatchdogSignal=SIGTERM."""

    def __init__(self, monkeypatch, name):
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.line.bind("\0" + name)
        monkeypatch.setenv("NOTIFY_SOCKET", "@" + name)
        monkeypatch.setenv("WATCHDOG_USEC", str(int(WATCHDOG_S * 1e6)))
        self.heard = []

    def wait_for(self, what, seconds=20.0):
        end = time.monotonic() + seconds
        while not any(what in text for text in self.heard):
            assert time.monotonic() < end, f"never heard {what}: {self.heard}"
            self._listen(0.1)

    def _listen(self, seconds):
        self.line.settimeout(seconds)
        try:
            self.heard.append(self.line.recv(4096).decode())
        except TimeoutError:
            pass

    def wait_for_silence(self, seconds=10.0):
        """Returns once the watchdog has not been fed for as long as it allows."""
        end = time.monotonic() + seconds
        fed = time.monotonic()
        while time.monotonic() - fed < WATCHDOG_S:
            assert time.monotonic() < end, "the watchdog is fed though what it watches stands still"
            before = len(self.heard)
            self._listen(0.02)
            if any("WATCHDOG=1" in text for text in self.heard[before:]):
                fed = time.monotonic()


@pytest.fixture
def manager(monkeypatch, tmp_path):
    it = Manager(monkeypatch, f"geodesic-test{tmp_path}")
    yield it
    it.line.close()


@pytest.fixture
def floating(pair, realtime, unhurried, manager):  # noqa: F811
    """A floating arm whose daemon has told the service manager so."""
    it = pair(unhurried)
    simulator = it.sim("--release", RELEASE_S)
    daemon = it.daemon("--exit-on-fault", *realtime)
    it.wait_for_state("active")
    manager.wait_for("READY=1")
    manager.wait_for("STATUS=active")
    manager.wait_for("WATCHDOG=1")
    return it, simulator, daemon


def truth(it, simulator):
    simulator.stop()
    return it.summary("sim")["joints"]


def is_stopped_under_control(joints):
    return all(not j["enabled"] and j["watchdog_trips"] == 0 for j in joints)


def test_the_drives_watch_the_daemon(floating):
    """The whole daemon stands still: each drive trips; the daemon wakes to a fault, and says so."""
    it, simulator, daemon = floating
    daemon.send(signal.SIGSTOP)
    time.sleep(1.0)
    daemon.send(signal.SIGCONT)
    assert daemon.wait(30) == 3, it.logs()
    joints = truth(it, simulator)
    assert all(j["watchdog_trips"] == 1 and not j["enabled"] for j in joints), joints
    assert it.summary("daemon")["final_state"] == "fault"


def test_the_daemon_watches_each_drive(pair, realtime, unhurried):  # noqa: F811
    """One drive falls silent: named, and the arm comes to its controlled stop."""
    it = pair(unhurried)
    it.sim("--release", RELEASE_S, "--fault", "joint2:silent@2.0")
    daemon = it.daemon("--exit-on-fault", *realtime)
    assert daemon.wait(60) == 3, it.logs()
    fault = it.summary("daemon")["faults"][0]
    assert (fault["name"], fault["joint"]) == ("joint_silent", "joint2"), it.logs()


def test_the_service_thread_watches_the_real_time_thread(floating, manager):
    """The real-time thread alone stands still: the drives stop the arm, the daemon names it, feeds
    the manager's watchdog no more and ends by itself."""
    it, simulator, daemon = floating
    stopped = Stopped(daemon.process.pid, REALTIME)
    manager.wait_for_silence()
    assert stopped.wait_for_end_of(daemon, 30) == 3, it.logs()
    assert "the real-time thread stands still" in daemon.output()
    assert it.summary("daemon")["torque_forced_off"] is True
    joints = truth(it, simulator)
    assert all(j["watchdog_trips"] == 1 and not j["enabled"] for j in joints), joints


def still_floats_then_stops(it, simulator, daemon, manager, wait):
    """The service thread is gone: the arm floats on; the manager notices, and its SIGTERM has the
    arm stop under control though nobody is there to log it."""
    manager.wait_for_silence()
    time.sleep(0.5)
    assert daemon.running()
    daemon.send(signal.SIGTERM)
    assert wait(daemon, 30) == 3, it.logs()
    joints = truth(it, simulator)
    assert is_stopped_under_control(joints), joints


def test_the_manager_watches_the_service_thread(floating, manager):
    """The service thread alone stands still."""
    it, simulator, daemon = floating
    stopped = Stopped(daemon.process.pid, SERVICE)
    still_floats_then_stops(it, simulator, daemon, manager, stopped.wait_for_end_of)
    assert it.summary("daemon")["service_hung"] is True


def test_the_service_thread_dies(floating, manager):
    it, simulator, daemon = floating
    Stopped(daemon.process.pid, SERVICE).resume_with_call(EXIT)
    still_floats_then_stops(it, simulator, daemon, manager, Program.wait)


def test_nobody_reads_the_log(pair, binaries, realtime, unhurried, manager):  # noqa: F811
    """A log that nobody reads is full at some time: it costs lines and nothing else."""
    it = pair(unhurried)
    simulator = it.sim("--release", RELEASE_S)
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    with subprocess.Popen(
            [binaries / "geodesicd", it.robot, *it.bus_arguments, "--socket", it.socket,
             "--summary", it.folder / "daemon.json", "--log-level", "debug", *realtime],
            stdin=subprocess.DEVNULL, stdout=writer, stderr=subprocess.DEVNULL) as daemon:
        it.wait_for_state("active")
        for _ in range(300):
            it.status.ask(cmd="status")  # a line each
        assert not select.select([], [writer], [], 0)[1], "the log is not full"
        manager.heard.clear()
        manager.wait_for("WATCHDOG=1")
        daemon.send_signal(signal.SIGTERM)
        assert daemon.wait(30) == 0
    os.close(reader)
    os.close(writer)
    joints = truth(it, simulator)
    assert is_stopped_under_control(joints), joints


def test_the_manager_hears_of_the_end(floating, manager):
    """All links whole: fed to the end, told of the stop, and no watchdog has tripped."""
    it, simulator, daemon = floating
    assert daemon.stop() == 0, it.logs()
    manager.wait_for("STOPPING=1", 1.0)
    joints = truth(it, simulator)
    assert is_stopped_under_control(joints), joints

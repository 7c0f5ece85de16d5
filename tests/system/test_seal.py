"""What the running daemon may still do: its real-time thread sealed, its capabilities gone, as root,
as a user with ambient capabilities, as a user with file capabilities."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

import pytest
from programs import Program, Status
from test_faults import RELEASE_S, unhurried  # noqa: F401  pylint: disable=unused-import
from threads import GETPID, Stopped, find

NOBODY = 65534
CAPABILITIES = "+sys_nice,+ipc_lock"


def facts(process, thread):
    """A thread's status as the kernel tells it."""
    text = pathlib.Path(f"/proc/{process}/task/{thread}/status").read_text(encoding="utf-8")
    return dict(line.split(":\t", 1) for line in text.splitlines() if ":\t" in line)


def check_bare(process, sanitized):
    """No thread has a capability, or can get one; the real-time thread alone is sealed. A sanitizer
    has threads of its own, and no seal."""
    if sanitized:
        return
    realtime = find(process, "geodesic-rt")
    threads = [int(task.name) for task in pathlib.Path(f"/proc/{process}/task").iterdir()]
    assert len(threads) >= 3
    for thread in threads:
        status = facts(process, thread)
        for name in ("CapInh", "CapPrm", "CapEff", "CapAmb"):
            assert int(status[name], 16) == 0, (thread, status)
        assert status["NoNewPrivs"] == "1", (thread, status)
        assert status["Seccomp"] == ("2" if thread == realtime else "0"), (thread, status)


def test_a_forbidden_call_is_a_named_fault(pair, realtime, unhurried):  # noqa: F811
    """The real-time thread is made to call getpid: not done, named, and a controlled stop."""
    it = pair(unhurried)
    it.may_be_refused = True
    simulator = it.sim("--release", RELEASE_S)
    daemon = it.daemon("--exit-on-fault", *realtime)
    sanitized = "sanitizer" in it.wait_for_state("active")["sealed_reason"]
    check_bare(daemon.process.pid, sanitized)
    time.sleep(0.5)
    Stopped(daemon.process.pid, "geodesic-rt").resume_with_call(GETPID)
    if sanitized:
        assert daemon.stop() == 0, it.logs()
        return
    assert daemon.wait(30) == 3, it.logs()
    summary = it.summary("daemon")
    fault = summary["faults"][0]
    assert (fault["name"], fault["class"]) == ("forbidden_call", "controlled_stop")
    assert "getpid was not made" in fault["text"]
    assert summary["sealed"] is True and summary["refused_calls"] == 1
    assert "asked for getpid at " in daemon.output()
    simulator.stop()
    joints = it.summary("sim")["joints"]
    assert all(not j["enabled"] and j["watchdog_trips"] == 0 for j in joints), joints


def test_no_seal_is_warned_about(pair):
    it = pair("planar2r")
    it.may_be_refused = True
    it.sim("--release", RELEASE_S, "--lockstep")
    daemon = it.daemon("--simulated-time", "--seconds", 0.5, "--no-seal")
    assert daemon.wait(60) == 0, it.logs()
    assert it.summary("daemon")["sealed"] is False
    assert "the real-time thread is not sealed: not asked for" in daemon.output()


@pytest.mark.parametrize("way", ["ambient", "file", "none"])
def test_as_an_ordinary_user(way, binaries, unhurried):  # noqa: F811
    """In real time by ambient or file capabilities, or refused with the fix; files are the user's."""
    if os.geteuid() != 0:
        way = "mine"  # whoever runs this is the ordinary user
    folder = pathlib.Path(tempfile.mkdtemp(prefix="geodesic-user"))
    try:
        robot = shutil.copytree(unhurried.parent, folder / "robot") / "robot.toml"
        program = shutil.copy(binaries / "geodesicd", folder / "geodesicd")
        user = []
        if way != "mine":
            for path in (folder, *folder.rglob("*")):
                os.chown(path, NOBODY, NOBODY)
            user = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
        as_user = [*user]
        if way == "ambient":
            as_user += [f"--inh-caps={CAPABILITIES}", f"--ambient-caps={CAPABILITIES}"]
        elif way == "file":
            subprocess.run(["setcap", "cap_sys_nice,cap_ipc_lock+ep", program], check=True)
        elif way == "none":
            as_user = ["prlimit", "--rtprio=0", "--memlock=8388608", *user]
        where = ["--bus", f"unix:{folder}/bus"]
        simulator = Program([*user, binaries / "geodesic", "sim", robot, *where, "--release",
                             RELEASE_S], folder / "sim.log")
        simulator.wait_for("answering on")
        arguments = [robot, *where, "--socket", folder / "daemon.sock", "--summary",
                     folder / "daemon.json", "--trace", folder / "trace.csv",
                     *(["--best-effort"] if way == "mine" else [])]
        daemon = Program([*as_user, program, *arguments], folder / "daemon.log")
        if way == "none":
            assert daemon.wait(20) == 1
            assert "SCHED_FIFO" in daemon.output() and "fix:" in daemon.output()
        else:
            status = Status(folder / "daemon.sock")
            end = time.monotonic() + 20
            state = None
            while state != "active":
                assert time.monotonic() < end, daemon.output()
                time.sleep(0.05)
                try:
                    state = status.status()["state"]
                except (OSError, ValueError):
                    pass
            last = status.status()
            sanitized = "sanitizer" in last["sealed_reason"]
            check_bare(daemon.process.pid, sanitized)
            assert last["sealed"] is not sanitized and last["refused_calls"] == 0
            assert last["realtime"] or way == "mine", daemon.output()
            assert daemon.stop() == 0, daemon.output()
            assert sanitized or "capabilities are left" not in daemon.output()
            owner = NOBODY if way != "mine" else os.geteuid()
            for name in ("daemon.json", "trace.csv"):
                assert (folder / name).stat().st_size > 0
                assert (folder / name).stat().st_uid == owner
        simulator.stop()
    finally:
        shutil.rmtree(folder)

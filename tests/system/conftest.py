"""The real daemon against the simulated arm, two processes on a bus (--bus vcan, unix,
or kvaser: two cards of the PREEMPT_RT machine, see ../lab)."""
import json
import pathlib
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "demonstration"))

from programs import Pair, may_be_realtime  # noqa: E402


def pytest_addoption(parser):
    parser.addoption("--bus", choices=["vcan", "unix", "kvaser"], default="unix")
    parser.addoption("--binaries", default=str(ROOT / "build" / "default" / "tools"))


@pytest.fixture
def bus(request):
    return request.config.getoption("--bus")


@pytest.fixture
def binaries(request):
    return pathlib.Path(request.config.getoption("--binaries"))


@pytest.fixture
def realtime():
    """What the daemon needs to be told to run here in real time: nothing, or --best-effort."""
    return [] if may_be_realtime() else ["--best-effort"]


@pytest.fixture
def robot_file():
    return lambda name: ROOT / "config" / "robots" / name / "robot.toml"


def check_sealed(pair_):
    """Whatever a test did: the loop ran sealed and asked for nothing it may not have."""
    summary = pair_.folder / "daemon.json"
    if getattr(pair_, "may_be_refused", False) or not summary.exists():
        return
    said = json.loads(summary.read_text(encoding="utf-8") or "{}")
    if said.get("final_state", "refused") != "refused":
        assert said["sealed"] or "sanitizer" in said["sealed_reason"], said["sealed_reason"]
        assert said["refused_calls"] == 0, pair_.logs()


@pytest.fixture
def pair(request, binaries, bus, tmp_path, robot_file):
    """pair("planar2r") -> simulated arm and daemon to be started; ended with the test."""
    opened = []

    def make(robot):
        path = robot if isinstance(robot, pathlib.Path) else robot_file(robot)
        opened.append(Pair(binaries, path, bus, tmp_path / f"pair{len(opened)}"))
        return opened[-1]

    yield make
    for one in opened:
        one.close()
    for one in opened:
        check_sealed(one)

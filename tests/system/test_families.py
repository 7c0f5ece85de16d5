"""planar2r with the drives of every family: it floats, a drive that contradicts the file is refused
before any torque, and families share a bus and an arm. What goes wrong on the way: faults.toml."""
import re

import families
import pytest

FAMILIES = families.load()
SECONDS = 3
RELEASE_S = 1.5


KVASER_RATE_HZ = 500


@pytest.fixture
def driven(robot_file, tmp_path, bus):
    """driven("odrive", torque_range_nm=3) -> robot.toml of planar2r with that family's drives."""
    def make(name, **defaults):
        family = families.changed(FAMILIES[name], **defaults)
        folder = tmp_path / f"{name}{len(defaults)}"
        return families.write_robot(family, robot_file("planar2r"), folder,
                                    family.get("kvaser_rate_hz", KVASER_RATE_HZ)
                                    if bus == "kvaser" else None)
    return make


def pytest_generate_tests(metafunc):
    """Every family; on kvaser those of classic CAN, the emulated card carries nothing else."""
    if "name" in metafunc.fixturenames:
        classic = metafunc.config.getoption("--bus") == "kvaser"
        said = "contradict" not in metafunc.function.__name__
        metafunc.parametrize("name", [name for name, family in FAMILIES.items()
                                      if not (classic and family["bus"]["fd"])
                                      and (said or "contradiction" in family)])


def floats(it, bus):
    """From power-on to torque and back, and nothing moves."""
    lockstep, simulated = (["--lockstep"], ["--simulated-time"]) if bus != "kvaser" else ([], [])
    sim = it.sim(*lockstep, "--release", RELEASE_S)
    daemon = it.daemon(*simulated, "--seconds", SECONDS + RELEASE_S)
    assert daemon.wait(100) == 0, it.logs()
    sim.stop()
    summary, truth = it.summary("daemon"), it.summary("sim")
    assert summary["faults"] == [], it.logs()
    assert summary["final_state"] == "off"
    assert all(joint["losses"] == 0 for joint in summary["joints"]), summary["joints"]
    assert all(joint["max_torque"] > 0.5 and not joint["enabled"] for joint in truth["joints"])
    free = truth["drift_by_second"][:SECONDS]
    assert len(free) == SECONDS, "the stand let go too late: nothing was proven"
    assert max(free) < 2e-3, truth


def test_family_floats(pair, driven, name, bus):
    floats(pair(driven(name)), bus)


# CANopen's NMT is identifier 0, on which CubeMars drives of the first kind answer: never together.
MIXED = [("damiao", "robstride"), ("robstride", "cia402"), ("cia402", "odrive"), ("odrive", "cubemars"),
         ("cubemars", "myactuator"), ("myactuator-motion", "odrive-05"), ("damiao-fd", "moteus")]


@pytest.mark.parametrize("first, second", MIXED)
def test_two_families_share_a_bus(pair, robot_file, tmp_path, bus, first, second):
    family = families.mixed(FAMILIES[first], FAMILIES[second])
    floats(pair(families.write_robot(family, robot_file("planar2r"), tmp_path / "mixed")), bus)


@pytest.mark.parametrize("first, second", [("damiao", "moteus"), ("moteus", "cia402")])
def test_a_robot_over_two_buses(pair, robot_file, tmp_path, bus, first, second):
    """Classic CAN and CAN FD, another family on each."""
    family = families.mixed(FAMILIES[first], FAMILIES[second])
    family["bus"] = FAMILIES[first]["bus"]
    floats(pair(families.write_robot(family, robot_file("planar2r"), tmp_path / "two",
                                     second=FAMILIES[second])), bus)


def test_family_contradicted(pair, driven, name):
    """The file says another thing than the drive: refused with register, found and expected."""
    it = pair(driven(name))
    sim = it.sim("--lockstep")
    it.robot = driven(name, **FAMILIES[name]["contradiction"])
    daemon = it.daemon("--simulated-time", "--seconds", 5, "--exit-on-fault")
    assert daemon.wait(60) == 3, it.logs()
    sim.stop()
    summary, truth = it.summary("daemon"), it.summary("sim")
    assert {fault["name"] for fault in summary["faults"]} == {"drive_refused"}, it.logs()
    assert re.search(FAMILIES[name]["contradiction_says"], daemon.output()), daemon.output()
    assert all(joint["max_torque"] == 0.0 for joint in truth["joints"]), "torque before the refusal"

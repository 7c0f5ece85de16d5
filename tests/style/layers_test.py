#!/usr/bin/python3
"""The layering test must be able to fail: includes that look the wrong way, and some that may."""
import pathlib
import unittest

from layers import judge

WRONG = [
    ("rt/ring.hpp", True, "control/joint.hpp"),
    ("rt/ring.hpp", False, "Eigen/Dense"),
    ("control/joint.hpp", True, "rt/clock.hpp"),
    ("control/controller.cpp", False, "chrono"),
    ("control/controller.cpp", False, "thread"),
    ("control/geometry/so3.hpp", True, "control/mechanism/mechanism.hpp"),
    ("control/mechanism/bias.cpp", True, "control/law/float.hpp"),
    ("drivers/arm.cpp", True, "config/robot.hpp"),
    ("drivers/damiao/codec.cpp", True, "drivers/odrive/codec.hpp"),
    ("drivers/arm.cpp", False, "spdlog/spdlog.h"),
    ("config/robot.cpp", True, "tools/sim/physics.hpp"),
    ("config/robot.cpp", False, "nlohmann/json.hpp"),
    ("tools/sim/physics.cpp", True, "physics.hpp"),
]
RIGHT = [
    ("rt/ring.hpp", False, "atomic"),
    ("rt/privileges.cpp", False, "sys/capability.h"),
    ("control/mechanism/bias.cpp", True, "control/geometry/so3.hpp"),
    ("control/controller.cpp", True, "control/law/float.hpp"),
    ("control/controller.cpp", False, "Eigen/Dense"),
    ("drivers/damiao/codec.cpp", True, "drivers/bus/frame.hpp"),
    ("drivers/bus/socketcan.cpp", False, "linux/can/raw.h"),
    ("tools/sim/physics.cpp", False, "mujoco/mujoco.h"),
    ("tests/rt/ring_test.cpp", False, "gtest/gtest.h"),
]


class Layers(unittest.TestCase):
    def test_wrong(self):
        for path, ours, include in WRONG:
            with self.subTest(path=path, include=include):
                self.assertTrue(judge(pathlib.PurePath(path), ours, include))

    def test_right(self):
        for path, ours, include in RIGHT:
            with self.subTest(path=path, include=include):
                self.assertIsNone(judge(pathlib.PurePath(path), ours, include))


if __name__ == "__main__":
    unittest.main()

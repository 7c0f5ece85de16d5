#!/usr/bin/env python3
"""Writes what the fuzzers start from: FOLDER/seeds/TARGET/* and FOLDER/TARGET.dict. All of it comes
from the golden vectors, the robots, the options' reference and the few lines below.

  tests/fuzz/seeds.py FOLDER
"""
import csv
import pathlib
import re
import struct
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
CAN_EFF, CAN_ERR = 0x80000000, 0x20000000


BENCHES = 16  # no fewer than tests/drivers/family_benches.hpp has; counted modulo theirs


def vectors(family="damiao"):
    """(identifier, data, from the drive) of every vector of a family."""
    with open(ROOT / f"tests/data/vectors/{family}.csv", newline="", encoding="utf-8") as file:
        return [(int(row["can_id"], 16), bytes.fromhex(row["data"]), row["direction"] != "command")
                for row in csv.DictReader(file)]


def all_vectors():
    """Of all families, and whether the identifier has 29 bits and the frame is CAN FD."""
    for path in sorted((ROOT / "tests/data/vectors").glob("*.csv")):
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                yield (path.stem, int(row["can_id"], 16), row["is_extended"] == "1",
                       row["is_fd"] == "1", bytes.fromhex(row["data"]))


def frames():
    for number, (_, identifier, extended, fd, data) in enumerate(all_vectors()):
        if number % 6 == 0 and not fd:
            flags = CAN_EFF if extended else 0
            kernel = struct.pack("<IB3x", identifier | flags, len(data)) + data.ljust(8, b"\0")
            yield f"classic{number}", b"\2\0\1" + kernel
    for number, (identifier, data, _) in enumerate(vectors()[::6]):
        wire = struct.pack("<IHHQ", 0x31424447, 1, number & 1, 0)
        wire += struct.pack("<qIBBH", 1000 + number, identifier, len(data), 0, 0) + data
        yield f"wire{number}", b"\0" + wire
    for flags in (0x40, 0x100, 0x4):  # bus-off, restarted, controller's state
        details = struct.pack("<IB3x", CAN_ERR | flags, 8) + b"\0\x20" + bytes(6)
        yield f"error{flags:x}", b"\2\0\1" + details + b"\1\1"
    yield "fd", b"\2\1" + struct.pack("<IBB2x", 0x123, 64, 1) + bytes(range(64))
    yield "extended", b"\2\0\1" + struct.pack("<IB3x", CAN_EFF | 0x12345678, 8) + bytes(8)
    yield "traffic", b"\1\0\1" + bytes([0, 0, 9, 7, 0, 0, 0x11] + [0] * 8) * 4 + b"\0\0\1\0\2\2"


def codec():
    for number, (_, data, _) in enumerate(vectors()):
        yield f"decode{number}", bytes([number % 4, 0, len(data)]) + data
    for kind in range(24):
        yield f"encode{kind}", bytes([kind % 4, 1] + [kind, 60, 60, 60] * 5)
    # A frame of a family: time, filter, kind, what the filter leaves open, data.
    for number, (_, identifier, extended, _, data) in enumerate(all_vectors()):
        for which in range(3):
            frame = bytes([0, 100, (number + which) % 256, 0]) + (identifier.to_bytes(4, "big") if extended
                                                          else b"") + data.ljust(8, b"\0")
            yield f"family{number}-{which}", bytes([0, 2, (number // 8 + which) % BENCHES]) + frame


def drives():
    monitor, enable, disable = bytes([0, 0]), bytes([1, 0]), bytes([2, 0])
    torque = bytes([1, 1, 100, 160, 0, 100, 128, 0, 100, 128, 0, 100, 0, 0, 100, 0, 0])
    cycles = lambda count, command: bytes([5, count - 1]) + command  # noqa: E731
    for bench in range(BENCHES):
        up = bytes([bench, 9, 0]) + cycles(100, monitor) * 5 + cycles(100, enable)
        yield f"up{bench}", up
        yield f"work{bench}", up + cycles(40, torque) + cycles(10, disable)
        yield f"power{bench}", (up + cycles(5, torque) + bytes([3, 0]) + cycles(40, torque)
                                + cycles(9, disable) + cycles(100, enable))
        for code in (1, 10, 34):
            yield f"error{bench}-{code}", up + bytes([3, 1, code]) + cycles(30, torque)
        yield f"restart{bench}", up + bytes([4, 0]) + cycles(100, monitor) * 2 + cycles(99, enable)
        yield f"silence{bench}", (up + bytes([0]) + torque + bytes([4, 1, 5, 0, 0, 0])
                                  + cycles(100, torque))
        yield f"spoilt{bench}", up + bytes([2]) + torque + b"\x10\x01" + b"\0" * 6 + cycles(9, torque)
        for number in range(6):
            forged = bytes([1, number, 0, 0, 0, 5, 3]) + bytes(range(number, number + 8))
            yield f"forged{bench}-{number}", up + forged + cycles(20, torque)


def simulated():
    talk = lambda count, mode, spoil: bytes([3, count - 1, mode, len(spoil)]) + spoil + b"\0"  # noqa: E731
    for bench in range(BENCHES):
        up = bytes([bench]) + talk(64, 0, b"") * 8 + talk(64, 1, b"")
        yield f"up{bench}", up
        yield f"shaft{bench}", up + bytes([0]) + bytes([60, 200, 0, 60, 100, 0, 0]) + talk(9, 1, b"")
        yield f"power{bench}", up + bytes([2, 1, 0]) + talk(64, 1, b"")
        yield f"spoilt{bench}", up + talk(1, 1, b"\0\1\2\3") + talk(5, 1, b"\xff" * 8)
        for number in range(6):
            show = bytes([7, 0, 3, 232, number, 0, 0, 0, 5, 3]) + bytes(range(9))
            yield f"forged{bench}-{number}", up + show + talk(9, 1, b"")


def candump():
    lines = ["(1436509052.249713) can0 001#7FFF7FF0000007FF", "can0  001   [8]  7F FF 7F F0 00 00 07 FF",
             "(2026-11-22 17:00:00.000001)  vcan0  RX - -  12345678   [4]  00 11 22 33",
             "can0 011##1" + "AB" * 64, "can0 011 [64] " + "AB " * 64, "can0 123#R", "# comment",
             "can0 20000040#0000000000000000", "can0 123#11.22.33", "can0 7FF#0100331500000000_9",
             "can0 123 [2] remote request"]
    for number, line in enumerate(lines):
        yield f"line{number}", line.encode()
    for number, (_, identifier, extended, fd, data) in enumerate(all_vectors()):
        if number % 4 == 0:
            text = f"can0 {identifier:0{8 if extended else 3}X}#{'#1' if fd else ''}"
            yield f"vector{number}", f"{text}{data.hex().upper()}".encode()


def states():
    yield "whole", (b'{"gravity": [0, 0, -9.81], "ee_frame": "tip", "floating_base": false, '
                    b'"joints": [{"name": "joint1", "nv": 1}, "joint2"], "states": '
                    b'[{"q": [0.1, -2e-1], "v": [0, 1], "a": [0, 0], "christoffel_first_kind": 1}]}')
    yield "least", b'{"states": [{"q": [0, 0]}]}'
    yield "none", b'{"states": []}'


REQUESTS = ['{"cmd":"status"}', '{"cmd":"law","law":"float"}', '{"cmd":"law","law":"zero"}',
            '{"cmd":"law","law":"flaot"}', '{"cmd":"stop"}', '{"cmd":"stop","exit":true}',
            '{"cmd":1}', "[]", '{"cmd":"stop","exit":"yes"}', '"\\ud800"']


def requests():
    for number, request in enumerate(REQUESTS):
        yield f"request{number}", bytes([number & 7]) + request.encode()


def control_stream():
    send = lambda peer, text: bytes([peer, 5, len(text) - 1]) + text + b"\1"  # noqa: E731
    for number, request in enumerate(REQUESTS):
        text = request.encode()[:40]
        yield f"stream{number}", send(0, text) + bytes([0, 3]) + send(1, text) + bytes([0, 1, 2, 3])
    yield "long", send(0, b"{") + bytes([0, 4, 0x13, 0x00]) + bytes([0, 3]) + send(0, b"}")
    yield "unread", b"".join(send(2, b'{"cmd":"status"}') for _ in range(12)) + bytes([2, 3, 2, 0])


def robot_file():
    for name in ("planar2r", "openarm"):
        text = (ROOT / f"config/robots/{name}/robot.toml").read_text(encoding="utf-8")
        yield name, text.encode()
        yield f"{name}-terse", "\n".join(
            line.split(" #")[0].rstrip() for line in text.splitlines()
            if line.strip() and not line.startswith("#")).encode()


def urdf():
    for file in ("config/robots/planar2r/planar2r.urdf", "config/robots/openarm/openarm.urdf",
                 "tests/data/oracles/ur5.urdf"):
        text = (ROOT / file).read_bytes()
        yield pathlib.Path(file).stem, text
        yield pathlib.Path(file).stem + "-strict", b"!" + text


def option_words():
    """Keys, tables and named choices of the options' reference, which the declarations write."""
    text = (ROOT / "config/OPTIONS.md").read_text(encoding="utf-8")
    words = set(re.findall(r"^\| `(\w+)`", text, flags=re.M))
    words |= {heading + "\n" for heading in re.findall(r"^## `(\[.*\])`", text, flags=re.M)}
    words |= {f'"{word}"' for word in re.findall(r"\b(float|hold|damp|report|stop|damiao)\b", text)}
    return words | {" = ", "true", "false", "[[joint]]\n", "{ ", " }", "1e308", "-1", "nan", "inf",
                    '"planar2r.urdf"', '"""', "'''", "0x", "1979-05-27T07:32:00Z"}


def urdf_words():
    words = {"NaN", "inf", "1e308", "-1", "1e-320", "<!--", "-->", "<![CDATA[", "&lt;", "mimic",
             'type="prismatic"', 'type="continuous"', 'type="floating"', 'type="planar"',
             '<mimic joint="', 'multiplier="', 'offset="', "quat_xyzw"}
    for file in (ROOT / "tests/data/oracles").glob("*.urdf"):
        for element in ElementTree.parse(file).iter():
            words |= {f"<{element.tag}", f"</{element.tag}>"}
            words |= {f' {key}="' for key in element.attrib}
    return words


DICTIONARIES = {
    "robot_file": option_words,
    "urdf": urdf_words,
    "states": lambda: {'"states"', '"q"', '"v"', '"a"', '"gravity"', '"joints"', '"name"', '"nv"',
                       '"ee_frame"', '"floating_base"', "1e999", "null", "[", "]", "{", "}"},
    "requests": lambda: {'"cmd"', '"law"', '"exit"', '"status"', '"stop"', '"float"', '"zero"',
                         '"tune"', '"set"', '"undo"', '"payload"', "true", "\\u0000", "1e999"},
    "candump": lambda: {"can0 ", "##", "#R", " [8] ", " [64] ", "(", ")", "[18446744073709551615]"},
}
SEEDS = [frames, codec, drives, simulated, candump, states, requests, control_stream, robot_file, urdf]


def write(folder):
    for seeds in SEEDS:
        target = folder / "seeds" / seeds.__name__
        target.mkdir(parents=True, exist_ok=True)
        for name, data in seeds():
            (target / name).write_bytes(data)
    for target, words in DICTIONARIES.items():
        quoted = ["".join(c if " " <= c <= "~" and c not in '"\\' else f"\\x{b:02X}"
                          for c, b in zip(word, word.encode())) for word in sorted(words())]
        (folder / f"{target}.dict").write_text(
            "".join(f'"{word}"\n' for word in quoted if word), encoding="ascii")


if __name__ == "__main__":
    write(pathlib.Path(sys.argv[1]))

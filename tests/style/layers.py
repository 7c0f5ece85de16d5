#!/usr/bin/python3
"""Reads every #include and fails on one that looks the wrong way (the house: rt, control, drivers,
config, tools), on a library a room may not use, and on a file that lies outside the rooms."""
import pathlib
import re
import subprocess
import sys

ROOMS = {  # room: (rooms it may include, libraries it may include besides C++, libc and Linux)
    "rt": ({"rt"}, {"sys/capability.h"}),
    "control": ({"control"}, {"Eigen/"}),
    "drivers": ({"rt", "control", "drivers"}, {"Eigen/", "fmt/"}),
    "config": ({"rt", "control", "drivers", "config"},
               {"Eigen/", "fmt/", "toml++/", "urdf_", "tinyxml2.h", "console_bridge/"}),
    "tools": ({"rt", "control", "drivers", "config", "tools"},
              {"Eigen/", "fmt/", "spdlog/", "CLI/", "nlohmann/", "mujoco/", "ginac/",
               "sys/capability.h"}),
    "tests": ({"rt", "control", "drivers", "config", "tools", "tests"}, {""}),
}
# Inside control/ the geometry knows no mechanism, the mechanism no law, and safety no law.
CONTROL = {
    "geometry": {"geometry"},
    "mechanism": {"geometry", "mechanism"},
    "law": {"geometry", "mechanism", "law"},
    "safety": {"geometry", "mechanism", "safety"},
}
# A family may look at the bus and at what all drives share, never at another family.
DRIVERS_SHARED = {"bus"}
TOP_LEVEL = {"CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE", *ROOMS}
# control/ is pure: no clock, no file, no thread, no socket.
IMPURE = re.compile(r"^(sys/|unistd\.h|fcntl\.h|time\.h|ctime|chrono|thread|mutex|atomic|fstream|"
                    r"iostream|cstdio|filesystem|poll\.h|pthread\.h|linux/)")
SYSTEM = re.compile(r"^([a-z_]+(\.h)?|c[a-z]+|(sys|linux|net|netinet|arpa|asm)/.*)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def complaints(root):
    listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard"],
                            check=True, capture_output=True, text=True).stdout.split("\n")
    for name in filter(None, listed):
        path = pathlib.PurePath(name)
        room = path.parts[0]
        if room not in TOP_LEVEL and not room.startswith("."):
            yield f"{name}: outside the rooms of the house ({', '.join(sorted(TOP_LEVEL))})"
        if room not in ROOMS or path.suffix not in {".hpp", ".cpp", ".h"}:
            continue
        file = pathlib.Path(root, name)
        if not file.exists():
            continue
        for number, line in enumerate(file.read_text().splitlines(), 1):
            found = INCLUDE.match(line)
            if not found:
                continue
            wrong = judge(path, found.group(1) == '"', found.group(2))
            if wrong:
                yield f"{name}:{number}: {wrong}: {line.strip()}"


def judge(path, ours, include):
    room = path.parts[0]
    rooms, libraries = ROOMS[room]
    if ours:
        target = pathlib.PurePath(include).parts
        if target[0] not in ROOMS:
            return "write our own headers from the root of the repository"
        if target[0] not in rooms:
            return f"{room}/ may not look at {target[0]}/"
        if room == target[0] == "control" and len(path.parts) > 2 and len(target) > 2:
            if target[1] not in CONTROL[path.parts[1]]:
                return f"control/{path.parts[1]}/ may not look at control/{target[1]}/"
        if room == target[0] == "drivers" and len(path.parts) > 2 and len(target) > 2:
            if target[1] not in DRIVERS_SHARED | {path.parts[1]}:
                return f"drivers/{path.parts[1]}/ may not look at drivers/{target[1]}/"
        return None
    if room == "control" and IMPURE.match(include):
        return "control/ is pure: no clock, file, thread or socket"
    if SYSTEM.match(include):
        return None
    if any(include.startswith(library) for library in libraries):
        return None
    return f"{room}/ may not use this library"


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else "."
    wrong = list(complaints(root))
    print("\n".join(wrong) if wrong else "every include looks the right way")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

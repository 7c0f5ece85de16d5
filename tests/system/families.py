"""planar2r with the drives of any family, as families.toml says. Starts nothing."""
import pathlib
import re
import tomllib

PARTS = ["bus", "default", "joint1", "joint2"]
OPTIONAL = ["rate_hz", "torque_limit", "least_torque_nm", "error_after_cycles",
            "kvaser_rate_hz"]
TEXTS = ["error", "error_says", "old_error_says", "watchdog_says", "power_cycle"]


def load():
    """Each family's table by its name. Raises ValueError where one lacks something."""
    with open(pathlib.Path(__file__).with_name("families.toml"), "rb") as file:
        families = tomllib.load(file)
    for name, family in families.items():
        needed = PARTS + TEXTS + ["contradiction", "contradiction_says"]
        if "tells_nothing" in family:
            needed = PARTS + TEXTS + ["tells_nothing"]
        missing = [key for key in needed if key not in family]
        unknown = set(family) - set(needed + OPTIONAL)
        if missing or unknown:
            raise ValueError(f"[{name}]: lacks {missing}, has unknown {sorted(unknown)}")
    return families


def value(of):
    if isinstance(of, bool):
        return str(of).lower()
    return f'"{of}"' if isinstance(of, str) else repr(of)


def inline(table):
    return "{ " + ", ".join(f"{key} = {value(of)}" for key, of in table.items()) + " }"


def driven_by(text, family):
    """planar2r's robot.toml with that family's drives."""
    text = re.sub(r"(^\[\[bus\]\]\n(?:[^\n]+\n)*)",
                  lambda found: found[1] + "".join(
                      f"{key} = {value(of)}\n" for key, of in family["bus"].items()
                      if not re.search(rf"^{key} *=", found[1], flags=re.M)),
                  text, count=1, flags=re.M)
    for key, of in family["bus"].items():
        text = re.sub(rf"^{key} *=[^\n]*", f"{key} = {value(of)}", text, count=1, flags=re.M)
    if "torque_limit" in family:
        text = re.sub(r"^torque_limit *=.*$", f"torque_limit = {family['torque_limit']}", text,
                      count=1, flags=re.M)
    if "rate_hz" in family:
        text = re.sub(r"^rate_hz *=.*$", f"rate_hz = {family['rate_hz']}", text, count=1, flags=re.M)
    drives = iter(family[part] for part in PARTS[1:])
    text, count = re.subn(r"^drive *= *\{[^\n]*", lambda _: "drive = " + inline(next(drives)), text,
                          flags=re.M)
    if count != 3:
        raise ValueError(f"planar2r has {count} lines 'drive = {{...', expected 3")
    return text


def mixed(first, second):
    """joint1 driven as `first` does, joint2 as `second`, on one bus that carries both."""
    result = {key: of for key, of in first.items() if key not in PARTS}
    for key in ("torque_limit", "rate_hz"):
        said = [family[key] for family in (first, second) if key in family]
        result |= {key: min(said)} if said else {}
    result["bus"] = first["bus"] | second["bus"]
    result["default"] = {}
    result["joint1"] = first["default"] | first["joint1"]
    result["joint2"] = second["default"] | second["joint2"]
    return result


def on_two_buses(text, second):
    """robot.toml with joint2 on a second bus, which is as the family `second` wants it."""
    bus = "".join(f"{key} = {value(of)}\n" for key, of in second["bus"].items())
    text = re.sub(r"(^name = \"joint2\"\n)", r'\1bus = "second"\n', text, count=1, flags=re.M)
    return text.replace("[defaults.joint]", f'[[bus]]\nname = "second"\ninterface = "can1"\n{bus}\n'
                        "[defaults.joint]", 1)


def changed(family, **defaults):
    """The family with other values in [defaults.joint] drive (or for a joint that says its own)."""
    result = {key: dict(of) if isinstance(of, dict) else of for key, of in family.items()}
    for key, of in defaults.items():
        for part in ("joint1", "joint2"):
            if key in result[part]:
                result[part][key] = of
                break
        else:
            result["default"][key] = of
    return result


def write_robot(family, source, folder, rate_hz=None, second=None):
    """planar2r with that family's drives in files of its own; the path of its robot.toml. With
    `second`, joint2 is on a second bus, as that family wants it."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    source = pathlib.Path(source)
    text = driven_by(source.read_text(encoding="utf-8"), family)
    if second:
        text = on_two_buses(text, second)
    if rate_hz:
        text = re.sub(r"^rate_hz *=.*$", f"rate_hz = {rate_hz}", text, count=1, flags=re.M)
    (folder / "planar2r.urdf").write_bytes((source.parent / "planar2r.urdf").read_bytes())
    path = folder / "robot.toml"
    path.write_text(text, encoding="utf-8")
    return path

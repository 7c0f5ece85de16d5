"""Reads faults.toml: rows with their kind of time's defaults, checked, and the robot files that
they ask for. Starts nothing.

Keys of a row (those marked * may be a table by kind of bus):
  name, what       how the row is called, and what goes wrong in words
  time             "simulated" (lockstep, deterministic) or "real"
  robot, options   a robot of config/robots, and what of its file is changed
  buses, not_on    kinds of bus it runs on; for every other kind the reason why not
  needs            "user-mode Linux": only in a machine of its own
  script *, push   faults of the simulated arm (geodesic sim --fault), pushes on it (--push)
  inject *         steps of fault_means.py, in order; the first one's moment counts
  before, undo *   shell commands before the programs start, and after they have ended
  sim, daemon      arguments beyond those of the kind of time; stays: without --exit-on-fault
  output           where the daemon's log goes: a file, "pipe", "/dev/full"; "tmpfs": a small disk
  families         "all": the row is played with every family of families.toml, whose texts stand for
                   {error}, {error_says} and the like; those named: the others have a reason
                   in not_families
  moments          tables of what differs by the moment at which it goes wrong; a row for each
  drives_on        the bus of the simulated arm if it is another one than the daemon's
Expected:
  fault *, of      name as in the policy table, or "none"; joint, list of joints, or "bus"
  class            what the policy table does about it
  within_cycles    from the injection to the event (and no later)
  final_state      of the daemon; exit: its exit status if another than the state says
  also             further faults and warnings that may come of it; any other one fails the row
  log, stderr      patterns that must be found
Expected where given:
  losses           replies lost by each joint, exactly; missed_at_least: cycles
  watchdog_trips   of every drive; drives_gone: nobody is left to ask
  torque_ever      false: no drive ever made torque (or least_torque_nm, where a family cannot say 0)
  reached          positions that joints must have gone below while active, as the daemon saw it
  bus_errno, send_failed_at_least    of the daemon's bus
  command_age      "checked": no command older than a cycle reached the drives; "held": none older
                   than what may wait on a bus that stands still, before it is thrown away
"""
import copy
import itertools
import pathlib
import re
import tomllib

import families

ROOT = pathlib.Path(__file__).resolve().parents[2]
KINDS = ["unix", "vcan", "vcan-echo", "kvaser"]
EXPECTED = ["fault", "final_state"]
WHERE_A_FAULT = ["class", "within_cycles"]
KNOWN = set("""name what time robot options buses not_on needs script push inject before undo sim daemon
stays output drives_on fault of class within_cycles final_state exit also log stderr losses
missed_at_least watchdog_trips drives_gone torque_ever reached bus_errno send_failed_at_least
command_age family moment least_torque_nm""".split())


def merged(base, over):
    result = copy.deepcopy(base)
    for key, value in over.items():
        nested = isinstance(value, dict) and isinstance(result.get(key), dict)
        result[key] = merged(result[key], value) if nested else copy.deepcopy(value)
    return result


def load(path=pathlib.Path(__file__).with_name("faults.toml")):
    """All rows, complete. Raises ValueError for one that could not fail."""
    with open(path, "rb") as file:
        table = tomllib.load(file)
    rows = []
    for given in itertools.chain.from_iterable(played(row) for row in table["row"]):
        defaults = table[given.get("time", "simulated")]
        row = merged({k: v for k, v in defaults.items() if k not in ("sim", "daemon", "also")}, given)
        for key in ("sim", "daemon", "also"):
            row[key] = defaults.get(key, []) + given.get(key, [])
        if row.get("stays"):
            row["daemon"].remove("--exit-on-fault")
        check(row, given)
        rows.append(row)
    names = [row["name"] for row in rows]
    if len(set(names)) != len(names):
        raise ValueError(f"a name is used twice in {path}")
    return rows


def filled(value, texts):
    """`value` with the family's texts in place of {error} and the like."""
    if isinstance(value, dict):
        return {key: filled(of, texts) for key, of in value.items()}
    if isinstance(value, list):
        return [filled(of, texts) for of in value]
    if isinstance(value, str):
        for key, of in texts.items():
            value = value.replace("{" + key + "}", of)
    return value


def played(row):
    """The rows that a row of the file stands for: one for each family and moment."""
    everybody = families.load()
    named = row.get("families", [None])
    reasons = row.get("not_families", {})
    if named == "all":
        named = [name for name in everybody if name not in reasons]
    elif named != [None]:
        silent = set(everybody) - set(named) - set(reasons)
        if silent:
            raise ValueError(f"{row['name']}: why not with {', '.join(sorted(silent))}?")
    for name, moment in itertools.product(named, row.get("moments", {None: {}})):
        one = {k: v for k, v in row.items() if k not in ("families", "not_families", "moments")}
        if moment is not None:
            one = merged(one, row["moments"][moment])
            one["name"] += "." + moment
            one["moment"] = moment
        if name is not None:
            family = everybody[name]
            one = filled(one, {k: v for k, v in family.items() if isinstance(v, str)})
            one["name"] += "." + name
            one["family"] = name
            if one["fault"] == "drive_error":
                one["within_cycles"] += family.get("error_after_cycles", 0)
            one["least_torque_nm"] = family.get("least_torque_nm", 0.0)
            if family["bus"]["fd"] and "kvaser" in one.get("buses", []):
                one["buses"] = [kind for kind in one["buses"] if kind != "kvaser"]
                one["not_on"] = {"kvaser": "the emulated card carries classic CAN only",
                                 **one.get("not_on", {})}
        yield one


def check(row, given):
    name = row.get("name", "a row without a name")
    needed = EXPECTED + (WHERE_A_FAULT if row.get("fault") != "none" else [])
    if row.get("final_state") == "killed":
        needed = ["fault", "within_cycles", "watchdog_trips"]
    missing = [key for key in ["name", "what", "time"] + needed if key not in row]
    if missing:
        raise ValueError(f"{name}: nothing is said of {', '.join(missing)}")
    unknown = set(row) - KNOWN
    if unknown:
        raise ValueError(f"{name}: what is {', '.join(sorted(unknown))}?")
    if not (given.get("script") or given.get("push") or given.get("inject")):
        raise ValueError(f"{name}: nothing goes wrong: no script, no push, no inject")
    silent = [kind for kind in KINDS if kind not in row["buses"] and kind not in row["not_on"]]
    if silent:
        raise ValueError(f"{name}: why not on {', '.join(silent)}?")


def of_kind(value, kind):
    """The value for this kind of bus, of a table by kinds or of a value for all."""
    if isinstance(value, dict) and set(value) & set(KINDS):
        return value.get(kind)
    return value


def reason_not_here(row, kind, own_machine):
    """None where the row runs, else why it does not."""
    if kind not in row["buses"]:
        return row["not_on"][kind]
    if row.get("needs") and not own_machine:
        return f"needs {row['needs']}"
    return None


def set_option(text, table, key, value):
    """`key = value` in the table of a robot's file; added where it is not there."""
    header = re.search(rf"^\[{re.escape(table)}\][^\n]*\n", text, flags=re.M)
    if header is None:
        return f"{text}\n[{table}]\n{key} = {value}\n"
    end = re.search(r"^\[", text[header.end():], flags=re.M)
    end = header.end() + end.start() if end else len(text)
    body = text[header.end():end]
    if key == "drive":  # an inline table: one value of it
        for name, inner in value.items():
            body, count = re.subn(rf"\b{name} *= *[^,}} ]+", f"{name} = {inner}", body, count=1)
            assert count == 1, f"{name} is not in [{table}] drive"
    else:
        line = f"{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}"
        line = line.replace("'", '"')
        body, count = re.subn(rf"^{key} *=[^\n]*", line, body, count=1, flags=re.M)
        body = body if count else f"{line}\n{body}"
    return text[:header.end()] + body + text[end:]


def write_robot(row, folder):
    """The row's robot in files of its own. Returns the path of its robot.toml."""
    source = ROOT / "config" / "robots" / row["robot"]
    text = (source / "robot.toml").read_text(encoding="utf-8")
    urdf = re.search(r'^urdf *= *"([^"]+)"', text, flags=re.M).group(1)
    text = text.replace(f'"{urdf}"', '"robot.urdf"', 1)
    if "family" in row:
        text = families.driven_by(text, families.load()[row["family"]])
    (folder / "robot.urdf").write_bytes((source / urdf).read_bytes())
    for table, values in row["options"].items():
        if isinstance(values, list):  # new tables, at the end
            for entry in values:
                lines = [f"{key} = {value!r}".replace("'", '"') for key, value in entry.items()]
                text += "\n".join(["", f"[[{table}]]", *lines, ""])
            continue
        if table == "defaults":
            table, values = "defaults.joint", values["joint"]
        for key, value in values.items():
            text = set_option(text, table, key, value)
    path = folder / "robot.toml"
    path.write_text(text, encoding="utf-8")
    return path

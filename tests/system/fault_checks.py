"""What must hold after a row of faults.toml has been played: each function asserts one thing, from
what the daemon and the simulated arm left behind. Starts nothing."""
import csv
import re

TORQUE_STATES = {"active", "stopping", "lowering"}
NS = 10**9


def daemon_trace(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def places(row):
    of = row.get("of", [])
    return [of] if isinstance(of, str) else of


def place(entry):
    return entry["joint"] or ("bus" if entry.get("bus") else "arm")


def faults(row, expected, summary):
    """The fault is there, on every joint or bus it was expected of, of its class; no others."""
    found = summary["faults"]
    named = [entry for entry in found if entry["name"] == expected]
    others = {entry["name"] for entry in found} - {expected} - set(row.get("also", []))
    assert not others, f"unexpected: {others}"
    if expected == "none":
        return named
    assert named, f"no {expected}; found {[entry['name'] for entry in found]}"
    assert {entry["class"] for entry in named} == {row["class"]}
    missing = set(places(row)) - {place(entry) for entry in named}
    assert not missing, f"{expected} does not name {missing}"
    return named


def log(row, expected, named, output):
    """Each event is told with name, place and moment, and what else the row asks for is there."""
    if expected != "none":
        for entry in named:
            where = entry["joint"] or entry.get("bus", "")
            line = rf"{expected} at .*{re.escape(where)}.*\[t = {entry['time']:.3f} s\]"
            assert re.search(line, output), f"no line like '{line}' in the log:\n{output}"
    for pattern in row.get("log", []):
        assert re.search(pattern, output), f"'{pattern}' is not in the log:\n{output}"


def torque_only_where_it_may_be(trace):
    """No torque is commanded outside active, stopping and lowering."""
    for record in trace:
        if record["state"] in TORQUE_STATES:
            continue
        for column, value in record.items():
            if column.startswith("command_"):
                assert float(value) == 0.0, f"{column} = {value} in {record['state']}"


def reached(row, trace):
    """The daemon saw the joint go there while it made torque."""
    for joint, below in row.get("reached", {}).items():
        seen = min(float(record[f"q_{joint}"]) for record in trace
                   if record["state"] in TORQUE_STATES)
        assert seen <= below, f"{joint} came to {seen} only"


def at_the_drives(row, truth):
    """No drive is left with torque; what the row says of watchdogs and torque is so."""
    for joint in truth["joints"]:
        assert joint["enabled"] is False, f"{joint['name']} is left enabled"
        if "watchdog_trips" in row:
            assert joint["watchdog_trips"] == row["watchdog_trips"], joint
        if row.get("torque_ever") is False:
            assert joint["max_torque"] <= row.get("least_torque_nm", 0.0), joint


def counters(row, summary):
    by_name = {joint["name"]: joint["losses"] for joint in summary["joints"]}
    for name, losses in row.get("losses", {}).items():
        assert by_name[name] == losses, by_name
    missed = max(summary["missed"], summary["skipped"])
    assert missed >= row.get("missed_at_least", 0), missed
    assert summary["events_dropped"] == 0
    assert summary["allocations"] == 0
    bus = summary["buses"][0]
    assert bus["send_failed"] >= row.get("send_failed_at_least", 0), bus
    if "bus_errno" in row:
        assert bus["last_errno"] == row["bus_errno"], bus


def command_ages(trace, first_tick_ns, arrivals, thrown_away_ns=None):
    """Age of every command when it reached the drives, from the cycle it belongs to [ns]. The bus
    keeps the order, so the k-th frame handed over is the k-th that arrives; but those that never
    arrived, which are counted, are looked for among the ones older than `thrown_away_ns`."""
    handed_over = []
    for record in trace:
        tick_ns = first_tick_ns + round(float(record["time_s"]) * NS)
        handed_over += [tick_ns] * int(record["sent_0"])
    assert len(handed_over) > 100, "the trace tells of hardly any frame"
    late = len(handed_over) - len(arrivals)
    assert 0 <= late <= 64, f"{len(handed_over)} frames handed over, {len(arrivals)} arrived"
    ages = []
    ticks = iter(handed_over)
    for stamp in arrivals:
        tick = next(ticks)
        while thrown_away_ns is not None and late > 0 and stamp - tick > thrown_away_ns:
            tick = next(ticks)
            late -= 1
        ages.append(stamp - tick)
    return ages


def command_age(row, trace, summary, arrivals):
    """No command older than one cycle reached a drive; on a bus that was held, none older than what
    may wait there before it is thrown away."""
    wake_ns = summary["wake_latency_ns"]["max"]
    limit_ns = summary["period_ns"] + wake_ns + 2_000_000  # as late as this machine woke the loop
    thrown_away_ns = None
    if row["command_age"] == "held":
        limit_ns += 20_000_000  # found held after 15 ms, by a thread that looks every 5
        thrown_away_ns = limit_ns
    ages = command_ages(trace, summary["first_tick_ns"], [stamp for stamp, _ in arrivals],
                        thrown_away_ns)
    old = [age for age in ages if age > limit_ns]
    assert not old, f"older than {limit_ns / 1e6} ms: {[age / 1e6 for age in old]} ms"
    return max(ages)

"""Decides from the true motion (the simulator's, not the daemon's) whether the arm floated."""
import motion

HELD_RAD = 1e-3      # held by compensation alone, before the push
MOVED_RAD = 0.02     # the push was felt
STAYED_RAD = 1e-3    # where it was left, over the last part of the run
FELL_RAD = 0.2       # the contrast: without compensation the arm falls


def judge(floating, falling, push_at, push_s, seconds):
    truth = floating["truth"]
    before = motion.between(truth, 0.0, push_at)
    pushed = motion.between(truth, push_at, seconds)
    end = min(seconds, truth["time"][-1])
    last = motion.between(truth, end - max(1.0, 0.2 * seconds), end - 0.05)
    fell = motion.between(falling["truth"], 0.0, 1.0)
    held_rad, moved_rad = motion.spread(truth, before), motion.spread(truth, pushed)
    stayed_rad, fell_rad = motion.spread(truth, last), motion.spread(falling["truth"], fell)
    daemon = floating["daemon"]
    checks = [
        ("held by compensation alone, until the push", held_rad, "<", HELD_RAD),
        ("moved by the push", moved_rad, ">", MOVED_RAD),
        ("stayed where it was left, in the last seconds", stayed_rad, "<", STAYED_RAD),
        ("fell without compensation, in one second", fell_rad, ">", FELL_RAD),
        ("faults", sum(fault["class"] != "warn" for fault in daemon["faults"]), "<", 1),
        ("allocations of the real-time thread", daemon["allocations"], "<", 1),
    ]
    rows = [{"what": what, "found": found, "relation": relation, "bound": bound,
             "holds": found < bound if relation == "<" else found > bound}
            for what, found, relation, bound in checks]
    return {
        "floats": all(row["holds"] for row in rows) and floating["exit_status"] == 0,
        "checks": rows,
        "seconds": seconds,
        "push": {"at_s": push_at, "for_s": push_s},
        "drift_rad": {"held": held_rad, "pushed": moved_rad, "stayed": stayed_rad,
                      "fell": fell_rad},
        "exit_status": floating["exit_status"],
        "daemon": daemon,
        "timing": daemon,
        "timing_from": "simulated time: nothing measured" if daemon["simulated_time"]
                       else "this run, real time",
        "sim": floating["sim"],
    }


def show(result):
    print("\nSUMMARY")
    for row in result["checks"]:
        found = f"{row['found']:.2e} rad" if isinstance(row["found"], float) else row["found"]
        bound = f"{row['bound']:g}"
        print(f"  {'ok  ' if row['holds'] else 'FAIL'} {row['what']:<48}{found:>14}"
              f"   ({row['relation']} {bound})")
    counts("the float", result["daemon"])
    timing = result["timing"]
    print(f"  latencies ({result['timing_from']}):")
    if timing is not result["daemon"]:
        counts("that run", timing)
    for name in ("wake_latency_ns", "cycle_time_ns", "state_to_torque_ns"):
        figures = timing[name]
        print(f"    {name[:-3].replace('_', ' '):<18}" + "  ".join(
            f"{key} {figures[key] / 1000:.1f} us" for key in ("p50", "p99", "p999", "max")))
    for fault in result["daemon"]["faults"]:
        print(f"  {fault['class']}: {fault['text']}")


def counts(what, daemon):
    lost = sum(joint["losses"] for joint in daemon["joints"])
    print(f"  {what}: cycles {daemon['cycles']}, missed {daemon['missed']}, replies lost {lost}, "
          f"page faults {daemon['page_faults']}, allocations {daemon['allocations']}, "
          f"faults {sum(fault['class'] != 'warn' for fault in daemon['faults'])}")

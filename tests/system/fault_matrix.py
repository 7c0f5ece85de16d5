#!/usr/bin/env python3
"""Prints faults.toml as a matrix with the marks of the last run (build/default/fault_matrix, or
--results): ok and the cycles it took, FAILED, - where a row does not run (--why says why)."""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import fault_rows  # noqa: E402


def results_of(folder):
    found = {}
    for path in sorted(folder.glob("*.json")):
        result = json.loads(path.read_text(encoding="utf-8"))
        found[result["row"], result["bus"]] = result
    return found


def mark(row, kind, results):
    if kind not in row["buses"]:
        return "-"
    result = results.get((row["name"], kind))
    if result is None:
        return "not run"
    if not result["passed"]:
        return "FAILED"
    return f"ok, {result['cycles']}" if "cycles" in result else "ok"


def expectation(row):
    fault = row["fault"]
    if isinstance(fault, dict):
        fault = " / ".join(dict.fromkeys(fault.values()))
    if fault == "none":
        return "carries on"
    of = row.get("of", "")
    of = ", ".join(of) if isinstance(of, list) else of
    return f"{fault}{f' ({of})' if of else ''}"


def table(rows, results):
    head = ["row", "what goes wrong", "time", "must follow", "class", "within", "ends", *fault_rows.KINDS]
    lines = [[row["name"], row["what"], row["time"], expectation(row), row.get("class", ""),
              str(row.get("within_cycles", "")), row["final_state"],
              *[mark(row, kind, results) for kind in fault_rows.KINDS]] for row in rows]
    return head, lines


def markdown(head, lines):
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for line in lines:
        print("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |")


def terminal(head, lines):
    widths = [max(len(line[i]) for line in [head, *lines]) for i in range(len(head))]
    for line in [head, *lines]:
        print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=pathlib.Path,
                        default=fault_rows.ROOT / "build" / "default" / "fault_matrix")
    parser.add_argument("--json", action="store_true", help="rows and results as JSON")
    parser.add_argument("--markdown", action="store_true", help="as a Markdown table")
    parser.add_argument("--why", action="store_true", help="why rows do not run on a kind of bus")
    arguments = parser.parse_args()
    rows, results = fault_rows.load(), results_of(arguments.results)
    if arguments.json:
        for row in rows:
            row["results"] = {kind: results.get((row["name"], kind)) for kind in row["buses"]}
        print(json.dumps(rows, indent=2))
        return
    if arguments.why:
        for row in rows:
            for kind, reason in row["not_on"].items():
                if kind not in row["buses"]:
                    print(f"{row['name']}: not on {kind}: {reason}")
        return
    (markdown if arguments.markdown else terminal)(*table(rows, results))
    failed = [key for key, result in results.items() if not result["passed"]]
    print(f"\n{len(rows)} rows; within: cycles allowed; after ok: cycles it took; "
          f"{len(results)} results, {len(failed)} failed")


if __name__ == "__main__":
    main()

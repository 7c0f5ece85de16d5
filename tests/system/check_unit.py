#!/usr/bin/env python3
"""Judges the systemd unit as far as that goes without systemd running: it parses without a word of
complaint, and its exposure stays under a limit. Usage: check_unit.py UNIT PROGRAM LIMIT."""
import pathlib
import re
import subprocess
import sys
import tempfile


def analyze(*arguments):
    done = subprocess.run(["systemd-analyze", *arguments], capture_output=True, text=True,
                          timeout=60, check=False)
    return done.returncode, done.stdout + done.stderr


def main():
    unit, program, limit = pathlib.Path(sys.argv[1]), sys.argv[2], float(sys.argv[3])
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder, unit.name)
        text = re.sub(r"^ExecStart=\S+", f"ExecStart={program}",
                      unit.read_text(encoding="utf-8"), flags=re.M)
        copy.write_text(text, encoding="utf-8")
        status, said = analyze("verify", "--man=no", str(copy))
    if status != 0 or said.strip():
        sys.exit(f"systemd-analyze verify {unit}: status {status}\n{said}")
    status, said = analyze("security", "--offline=true", "--no-pager", str(unit))
    found = re.search(r"Overall exposure level for \S+: ([\d.]+) (\w+)", said)
    if not found:
        sys.exit(f"systemd-analyze security {unit}: status {status}\n{said}")
    print("\n".join(line for line in said.splitlines() if line.startswith("✗")))
    print(f"exposure {found[1]} ({found[2]}), limit {limit}")
    return 0 if float(found[1]) <= limit else 1


if __name__ == "__main__":
    sys.exit(main())

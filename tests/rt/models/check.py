#!/usr/bin/env python3
"""Has spin try every run of the models in this folder: the right ones must hold, and every wrong
variant that a model's first comment names must fail. Checks no C++; exchange_test.cpp does."""
import pathlib
import re
import subprocess
import sys
import tempfile

MODELS = pathlib.Path(__file__).resolve().parent


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300,
                          check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def check(model, variant):
    """Returns (errors, states, what the first error was)."""
    with tempfile.TemporaryDirectory() as folder:
        choice = [f"-D{variant}"] if variant else []
        run(["spin", *choice, "-a", str(model)], folder)
        # -DSAFETY: assertions and dead ends; no cycle is a fault, to look again is allowed.
        run(["cc", "-O1", "-w", "-DSAFETY", "-DNOREDUCE", "-o", "pan", "pan.c"], folder)
        report = run(["./pan", "-m100000"], folder)
    errors = int(re.search(r"errors: (\d+)", report).group(1))
    states = int(re.search(r"(\d+) states, stored", report).group(1))
    assert "max search depth too small" not in report, report
    found = re.search(r"pan:\d+: (.*?)(?: \(at depth|$)", report, re.M)
    return errors, states, found.group(1) if found else ""


def main():
    bad = 0
    for model in sorted(MODELS.glob("*.pml")):
        comment = model.read_text(encoding="utf-8").split("*/")[0]
        variants = re.findall(r"^ {5}([A-Z_]+) {2,}", comment, re.M)
        assert variants, f"{model} names no wrong variant"
        for variant in [None, *variants]:
            errors, states, found = check(model, variant)
            fine = (errors > 0) == (variant is not None)
            bad += not fine
            print(f"{'ok ' if fine else 'BAD'} {model.stem:14} {variant or '(right)':16} "
                  f"{states:8} states, {found or 'holds in every run'}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

"""Reads the simulated arm's trace (CSV with a header) into columns; time 0 is the release."""
import csv


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ValueError(f"{path}: no rows")
    columns = {name: [float(row[name]) for row in rows] for name in rows[0]}
    joints = [name[2:] for name in rows[0] if name.startswith("q_")]
    return {"time": columns["time_s"], "joints": joints,
            "q": [columns[f"q_{j}"] for j in joints],
            "v": [columns[f"v_{j}"] for j in joints],
            "torque": [columns[f"torque_{j}"] for j in joints]}


def between(motion, start, end):
    """Indices of the samples with start <= time < end."""
    return [i for i, t in enumerate(motion["time"]) if start <= t < end]


def spread(motion, indices):
    """Largest excursion of any joint over these samples [rad or m]."""
    return max(max(q[i] for i in indices) - min(q[i] for i in indices)
               for q in motion["q"]) if indices else float("nan")

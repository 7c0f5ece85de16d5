"""Draws what tests/bench/run measured: the cycle by phase over joints, dynamics beside others."""

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot


def draw_cycle(axes, cycle):
    joints = [robot["joints"] for robot in cycle]
    phases = [name for name in cycle[0]["ns"] if name != "sum"]
    rows = [[robot["ns"][name]["median"] / 1e3 for robot in cycle] for name in phases]
    axes.stackplot(joints, rows, labels=phases)
    axes.set(xlabel="joints", ylabel="µs a cycle (median)", title="Cycle by phase, bus in memory")
    axes.legend(loc="upper left")


def draw_dynamics(axes, dynamics):
    groups = [
        (f"{robot['robot']}\n{function}", timed)
        for robot in dynamics
        for function, timed in robot["ns"].items()
        if function in ("bias", "gravity", "mass matrix")
    ]
    names = list(groups[0][1])
    width = 0.8 / len(names)
    for k, who in enumerate(names):
        places = [i + (k - (len(names) - 1) / 2) * width for i in range(len(groups))]
        axes.bar(places, [timed.get(who, {}).get("median", 0.0) for _, timed in groups], width, label=who)
    axes.set_xticks(range(len(groups)), [name for name, _ in groups], fontsize=6)
    axes.set(ylabel="ns a call (median)", title="Dynamics", yscale="log")
    axes.legend()


def draw(figures, file):
    parts = [(draw_cycle, "cycle"), (draw_dynamics, "dynamics")]
    parts = [(part, figures[name]) for part, name in parts if name in figures]
    figure, axes = pyplot.subplots(len(parts), 1, figsize=(10, 5 * len(parts)), squeeze=False)
    for (part, data), place in zip(parts, axes[:, 0]):
        part(place, data)
    figure.tight_layout()
    figure.savefig(file, dpi=120)

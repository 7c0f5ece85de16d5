"""Draws what `geodesic shoot` computed: joints, the way in the workspace, energy, momentum.
Arguments: the JSON of the command, the picture's file."""
import json
import math
import sys

try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError as missing:
    print(missing, file=sys.stderr)
    sys.exit(3)

INK, QUIET, BOUND = "#222222", "#8a8a8a", "#c23b22"
TINY = 1e-17  # a logarithm's zero


def finish(axes, title, x, y):
    axes.set_title(title, loc="left", fontsize=11, color=INK)
    axes.set_xlabel(x, color=INK)
    axes.set_ylabel(y, color=INK)
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)


def draw_joints(axes, shot, shown, line):
    colours = pyplot.get_cmap("tab10" if len(shot["joints"]) <= 10 else "tab20").colors
    for i, joint in enumerate(shot["joints"]):
        unit = 180.0 / math.pi if joint["turns"] else 1000.0
        colour = colours[i % len(colours)]
        axes.plot(shown["time"], [unit * q[joint["q"]] for q in shown["q"]], lw=1.4, color=colour,
                  label=joint["name"])
        if line:
            axes.plot(line["time"], [unit * q[joint["q"]] for q in line["q"]], lw=1.0, ls="--",
                      color=colour, alpha=0.6)
    if shot["joints"]:
        axes.legend(fontsize=8, ncol=2 if len(shot["joints"]) > 4 else 1, frameon=False)
    slides = any(not joint["turns"] for joint in shot["joints"])
    finish(axes, "Joints" + (" (dashed: straight line)" if line else ""), "time [s]",
           "angle [deg], way [mm]" if slides else "angle [deg]")


def draw_way(axes, shot, shown, line):
    ways = [shown["position"]] + ([line["position"]] if line else [])
    spread = [max(p[k] for way in ways for p in way) - min(p[k] for way in ways for p in way)
              for k in range(3)]
    flat = min(range(3), key=lambda k: (spread[k], -k))
    a, b = (k for k in range(3) if k != flat)
    axes.plot([p[a] for p in ways[0]], [p[b] for p in ways[0]], lw=1.4, color="tab:blue",
              label="geodesic" if line else None)
    if line:
        axes.plot([p[a] for p in ways[1]], [p[b] for p in ways[1]], lw=1.0, ls="--", color=QUIET,
                  label="straight line in joint space")
        axes.legend(fontsize=8, frameon=False)
    axes.plot(ways[0][0][a], ways[0][0][b], "o", color=INK, ms=5)
    axes.plot(ways[0][-1][a], ways[0][-1][b], "s", color=INK, ms=5)
    axes.set_aspect("equal", adjustable="datalim")
    finish(axes, f"Way of {shot['ee_frame']} (from dot to square)", f"{'xyz'[a]} [m]",
           f"{'xyz'[b]} [m]")


def draw_energy(axes, shot, line):
    motion = shot["trajectory"]
    if line:
        axes.plot(motion["time"], motion["kinetic_energy"], lw=1.4, color="tab:blue",
                  label="geodesic: constant")
        axes.plot(line["time"], line["kinetic_energy"], lw=1.0, ls="--", color=QUIET,
                  label="straight line")
        axes.set_ylim(0.0, 1.3 * max(motion["kinetic_energy"] + line["kinetic_energy"]) or 1.0)
        axes.legend(fontsize=8, frameon=False)
        finish(axes, "Kinetic energy: its integral is the action", "time [s]", "T [J]")
        return
    start = motion["energy"][0] or 1.0
    axes.plot(motion["time"], [e / start - 1.0 for e in motion["energy"]], lw=0.7, color="tab:blue")
    energy = shot["energy"]
    finish(axes, f"Energy, E / E(0) - 1: drift over all {energy['drift']:+.1e} "
           f"± {2.0 * energy['drift_noise']:.0e}", "time [s]", "relative change")


def draw_momentum(axes, shot):
    motion = shot["trajectory"]
    first = motion["momentum"][0]
    for name, part, colour in (("linear", slice(0, 3), "tab:blue"),
                               ("angular", slice(3, 6), "tab:orange")):
        size = math.hypot(*first[part]) or 1.0
        values = [max(TINY, math.dist(p[part], first[part]) / size) for p in motion["momentum"]]
        axes.plot(motion["time"][1:], values[1:], lw=0.7, color=colour, label=name)
    axes.axhline(1e-10, color=BOUND, lw=1.0, ls=":", label="promised: 1e-10")
    axes.set_yscale("log")
    axes.set_ylim(top=1e-8)
    axes.legend(fontsize=8, frameon=False, ncol=3)
    finish(axes, "Momentum about the world's origin", "time [s]", "relative change")


def main():
    with open(sys.argv[1]) as file:
        shot = json.load(file)
    line = shot.get("straight_line")
    shown = shot.get("opening", shot["trajectory"])
    with_momentum = "momentum" in shot and not line
    rows = 2 if with_momentum else 1
    figure = pyplot.figure(figsize=(12, 3.0 + 3.2 * (rows + 0.6)))
    grid = figure.add_gridspec(2 + (rows - 1), 2, height_ratios=[1.5] + [1.0] * rows)
    draw_joints(figure.add_subplot(grid[0, 0]), shot, shown, line)
    draw_way(figure.add_subplot(grid[0, 1]), shot, shown, line)
    draw_energy(figure.add_subplot(grid[1, :]), shot, line)
    if with_momentum:
        draw_momentum(figure.add_subplot(grid[2, :]), shot)
    what = "geodesic" if not any(shot["gravity"]) else "free motion under gravity"
    steps = f"{shot['steps']:,} steps of {1e3 * shot['duration'] / shot['steps']:.3g} ms"
    figure.suptitle(f"{shot['robot']}{', floating' if shot['floating_base'] else ''}: {what}, "
                    f"{steps}, {shot['integrator']} integrator", x=0.01, ha="left", color=INK)
    figure.tight_layout()
    try:
        figure.savefig(sys.argv[2], dpi=100)
    except (OSError, ValueError) as problem:
        sys.exit(f"geodesic: {sys.argv[2]}: {problem}")


main()

"""Draws the demo's picture: joint angles with and without compensation, and the torques."""
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (the backend must be chosen first)

INK, QUIET, PUSH, STOP = "#222222", "#8a8a8a", "#f2b84b", "#d9d9d9"


def change_deg(motion, joint):
    start = next((i for i, t in enumerate(motion["time"]) if t >= 0.0), 0)
    return [57.29577951308232 * (q - motion["q"][joint][start]) for q in motion["q"][joint]]


def panel(axes, motion, values, result, title, unit, push_at, until, stopped_at=None):
    colours = pyplot.get_cmap("tab10" if len(motion["joints"]) <= 10 else "tab20").colors
    axes.axvspan(push_at, push_at + result["push"]["for_s"], color=PUSH, alpha=0.6, lw=0)
    axes.axvline(0.0, color=QUIET, lw=0.8, ls=":")
    if stopped_at is not None:
        axes.axvspan(stopped_at, until, color=STOP, alpha=0.5, lw=0)
        axes.text(until, 0.02, "stopped, lowered ", transform=axes.get_xaxis_transform(),
                  fontsize=8, color=INK, va="bottom", ha="right")
    for joint, name in enumerate(motion["joints"]):
        axes.plot(motion["time"], values(joint), lw=1.4, color=colours[joint % len(colours)],
                  label=name)
    axes.set_xlim(-1.5, until)
    axes.set_title(title, loc="left", fontsize=11, color=INK)
    axes.set_ylabel(unit, color=INK)
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)


def draw(floating, falling, result, path):
    figure, (top, middle, bottom) = pyplot.subplots(3, 1, figsize=(10, 9.5), sharex=True)
    truth, fallen = floating["truth"], falling["truth"]
    until, push_at = truth["time"][-1], result["push"]["at_s"]
    panel(top, truth, lambda j: change_deg(truth, j), result,
          "Compensation on: held, pushed (yellow), left alone", "change of angle [deg]",
          push_at, until, result["seconds"])
    panel(middle, fallen, lambda j: change_deg(fallen, j), result,
          "Compensation off, the same push: it falls when the stand lets go at 0 s",
          "change of angle [deg]", 1.0, until)
    panel(bottom, truth, lambda j: truth["torque"][j], result,
          "Compensation on: torque the drives make", "torque [N·m]", push_at, until,
          result["seconds"])
    middle.legend(*top.get_legend_handles_labels(), fontsize=9, ncol=2, frameon=False,
                  loc="center right")
    bottom.set_xlabel("time since the stand let go [s]")
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    pyplot.close(figure)

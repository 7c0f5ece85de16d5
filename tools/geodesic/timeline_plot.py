"""Draws a cycle on the wire as `geodesic check` models it: a row a drive, a panel a bus.
Arguments: the JSON of the timelines, the picture's file."""
import json
import sys

try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.patches import Patch
except ImportError as missing:
    print(missing, file=sys.stderr)
    sys.exit(3)

INK, QUIET, BOUND = "#222222", "#8a8a8a", "#c23b22"
COMMAND, REPLY = "tab:blue", "tab:orange"


def bar(axes, row, frame, height, prefix, alpha):
    start, end = frame[prefix + "start_us"], frame[prefix + "end_us"]
    axes.broken_barh([(start, end - start)], (row - height / 2.0, height), linewidth=0.4,
                     edgecolor="white", facecolor=REPLY if frame["reply"] else COMMAND, alpha=alpha)


def draw_bus(axes, bus):
    rows = {name: -1 - i for i, name in enumerate(bus["order"])}
    waits = {}
    for frame in bus["frames"]:
        row = rows[frame["joint"]]
        bar(axes, 0, frame, 0.8, "", 1.0)
        bar(axes, row, frame, 0.8, "", 0.45)
        bar(axes, row, frame, 0.35, "best_", 1.0)
        if frame["reply"] and row in waits:
            axes.plot([waits[row], frame["ready_us"]], [row, row], color=QUIET, lw=1.0)
            axes.plot([frame["ready_us"], frame["start_us"]], [row, row], color=QUIET, lw=1.0,
                      ls=":")
        if not frame["reply"]:
            waits[row] = frame["end_us"]
    bounds = ((bus["deadline_us"], "replies are lost from here on", "--"),
              (bus["period_us"], "next cycle", "-"))
    for x, words, style in bounds:
        axes.axvline(x, color=BOUND, lw=1.0, ls=style)
        axes.annotate(words, (x, min(rows.values()) - 0.5), xytext=(-3, 2), fontsize=7, ha="right",
                      va="bottom", textcoords="offset points", color=BOUND, rotation=90)
    axes.set_yticks([0, *rows.values()], ["wire", *rows])
    axes.set_ylim(min(rows.values()) - 0.6, 0.6)
    axes.set_xlim(0.0, max(bus["period_us"], bus["end_us"]) * 1.01)
    axes.set_xlabel("time since the cycle began [µs]", color=INK)
    axes.set_title(
        f"bus {bus['bus']}: last reply at {bus['end_us']:.0f} µs, slack {bus['slack_us']:.0f} µs, "
        f"headroom {bus['headroom_us']:.0f} µs, idle {bus['idle_us']:.0f} µs, "
        f"limit {bus['limit_hz']:.0f} Hz", loc="left", fontsize=10, color=INK)
    axes.grid(axis="x", alpha=0.25)
    axes.tick_params(axis="y", labelsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def main():
    with open(sys.argv[1]) as file:
        shown = json.load(file)
    buses = shown["buses"]
    heights = [1.6 + 0.26 * (1 + len(bus["order"])) for bus in buses]
    figure, axes = pyplot.subplots(len(buses), 1, figsize=(11, 0.6 + sum(heights)), squeeze=False,
                                   gridspec_kw={"height_ratios": heights})
    for place, bus in zip(axes[:, 0], buses):
        draw_bus(place, bus)
    axes[0, 0].legend(
        handles=[Patch(color=COMMAND, label="command"), Patch(color=REPLY, label="reply"),
                 Patch(color=QUIET, alpha=0.45, label="pale: as many stuff bits as there can be")],
        fontsize=8, frameon=False, ncol=3, loc="lower right", bbox_to_anchor=(1.0, 1.04))
    figure.suptitle(f"{shown['robot']}: a cycle at {shown['rate_hz']:.6g} Hz", x=0.01, ha="left",
                    color=INK)
    figure.tight_layout()
    try:
        figure.savefig(sys.argv[2], dpi=90)
    except (OSError, ValueError) as problem:
        sys.exit(f"geodesic: {sys.argv[2]}: {problem}")


main()

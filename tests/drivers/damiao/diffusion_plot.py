#!/usr/bin/python3
"""Draws drivers/damiao/error_diffusion.png from figures that the driver's own test writes.
Arguments: the test program (build/default/tests/test_drivers), the picture's file."""
import csv
import os
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

TEST = "DamiaoDiffusion.WritesWhatThePlotShows"
WINDOW = 20  # cycles of the running mean


def figures(program):
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "figures.csv")
        subprocess.run([program, f"--gtest_filter={TEST}"], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "GEODESIC_DIFFUSION_CSV": file})
        with open(file, newline="") as lines:
            rows = [{key: float(value) for key, value in row.items()}
                    for row in csv.DictReader(lines)]
    return {key: [row[key] for row in rows] for key in rows[0]}


def running_mean(values):
    return [sum(values[i - WINDOW + 1:i + 1]) / WINDOW for i in range(WINDOW - 1, len(values))]


def main():
    shown = figures(sys.argv[1])
    milli = {key: [1e3 * value for value in values] for key, values in shown.items()}
    time = milli["time"]
    figure, (top, bottom) = pyplot.subplots(2, 1, figsize=(9, 6), sharex=True)
    top.step(time, milli["diffused"], where="post", lw=0.6, color="tab:orange",
             label="sent, with diffusion")
    top.step(time, milli["rounded"], where="post", lw=1.4, color="tab:blue",
             label="sent, rounded only")
    top.plot(time, milli["wanted"], lw=1.4, color="#222222", label="commanded")
    top.set_ylabel("torque [mN·m]")
    top.set_title(f"A DM8009's torque code is {milli['torque_code'][0]:.0f} mN·m wide: what leaves at 1 kHz",
                  loc="left", fontsize=10)
    top.legend(fontsize=8, frameon=False, ncol=3, loc="lower center")
    for name, colour, words in (("rounded", "tab:blue", "rounded only"),
                                ("diffused", "tab:orange", "with diffusion")):
        error = [sent - wanted for sent, wanted in zip(milli[name], milli["wanted"])]
        bottom.plot(time[WINDOW - 1:], running_mean(error), lw=1.4, color=colour, label=words)
    bottom.set_ylabel("error [mN·m]")
    bottom.set_xlabel("time [ms]")
    bottom.set_title(f"Error of the mean of {WINDOW} cycles", loc="left", fontsize=10)
    bottom.legend(fontsize=8, frameon=False, ncol=2, loc="upper right", bbox_to_anchor=(1.0, 1.14))
    for axes in (top, bottom):
        axes.grid(alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=80)


main()

"""Draw the paper's figure 2 with our runs of Table 1: `python docs/figure2.py` writes docs/images/figure2.svg."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
import matplotlib.pyplot as plt

from wpcal.calibrate import anneal_pairs
from wpcal.optim import AnnealingSchedule
from wpcal.taught.pairs import read_pairs

ROOT = Path(__file__).parents[1]
PAPER_MM = 0.221581
OPTIMUM_MM = 0.2198230047896


def main() -> None:
    plt.rcParams["svg.hashsalt"] = "figure2"  # the same drawing gives the same bytes
    pairs, _ = read_pairs(ROOT / "fixtures" / "yin2003" / "table1.csv")
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
    schedules = {
        "published schedule, one chain": AnnealingSchedule.yin2003(),
        "default, 128 chains": AnnealingSchedule(),
    }
    for axis, (title, schedule) in zip(axes, schedules.items(), strict=True):
        _, report = anneal_pairs(pairs, schedule=schedule, seed=0)
        axis.semilogy(report.trace.cost, color="0.6", lw=1, label="f after each temperature")
        axis.semilogy(report.trace.best_cost, color="C0", lw=1.6, label="best f so far")
        axis.axhline(PAPER_MM, color="C3", lw=0.8, ls="--", label=f"the paper's {PAPER_MM} mm")
        axis.axhline(OPTIMUM_MM, color="k", lw=0.8, ls=":", label="certified optimum 0.219823 mm")
        axis.set_title(f"{title}: {report.cost:.6f} mm, {report.evaluations} evaluations", fontsize=9)
        axis.set_xlabel("temperature step k")
    axes[0].set_ylabel("largest distance f / mm")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(ROOT / "docs" / "images" / "figure2.svg", metadata={"Date": None})


main()

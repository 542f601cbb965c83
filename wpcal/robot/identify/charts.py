"""Charts of an identification, like figures 4 to 6 of Xiong, Yang, Wang 2015; they need matplotlib (extra `plots`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from wpcal.robot.identify.error_summary import distances_mm, turns_deg
from wpcal.robot.identify.genetic_tabu import GeneticTabuFit
from wpcal.robot.identify.identification import Identification
from wpcal.robot.identify.identification_record import parameter_rows

BEFORE, AFTER = "#b35900", "#00527a"
"""Told apart in print and by readers who see no red or green."""


@style.context("default")  # not that of a matplotlibrc in the current folder, which could even start TeX
def write_charts(result: Identification, folder: Path) -> list[str]:
    """Write the charts as PNG files into a folder and return their names.

    Parameters
    ----------
    folder : Path
        ``errors.png``: errors of the test poses before and after. ``parameters.png``: changes with 95 % intervals.
        ``fitness.png``: the search, where there was one.
    """
    names = ["errors.png", "parameters.png"]
    _errors(result, folder / names[0])
    _parameters(result, folder / names[1])
    if result.search is not None:
        _fitness(result.search, len(result.train), folder / "fitness.png")
        names.append("fitness.png")
    return names


def _errors(result: Identification, path: Path) -> None:
    kinds = [("distance, mm", distances_mm(result.errors_before), distances_mm(result.errors_after))]
    before, after = turns_deg(result.errors_before), turns_deg(result.errors_after)
    if before is not None and after is not None:
        kinds.append(("turn, degrees", before, after))
    figure = Figure(figsize=(8.0, 2.8 * len(kinds)), layout="constrained")
    for place, (label, first, second) in enumerate(kinds, start=1):
        axes = figure.add_subplot(len(kinds), 1, place)
        poses = np.arange(1, len(first) + 1)
        axes.semilogy(poses, first, "o-", color=BEFORE, label="nominal")
        axes.semilogy(poses, second, "s-", color=AFTER, label="identified")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("test pose")
        axes.set_ylabel(label)
        axes.grid(visible=True, alpha=0.3)
        axes.legend()
    figure.suptitle(f"{result.arm.name}: errors of poses that were not fitted")
    figure.savefig(path, dpi=120, metadata={"Software": None})


def _parameters(result: Identification, path: Path) -> None:
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    for place, unit in enumerate(("mm", "deg"), start=1):
        rows = [row for row in parameter_rows(result) if row["unit"] == unit]
        axes = figure.add_subplot(2, 1, place)
        change = [row["change"] for row in rows]
        half = None if result.half_widths is None else [row["half_width_95"] for row in rows]
        axes.bar(range(len(rows)), change, yerr=half, color=AFTER, ecolor=BEFORE, capsize=4)
        axes.set_xticks(range(len(rows)), [row["name"] for row in rows], rotation=60)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set_ylabel(f"change, {unit}")
    figure.suptitle(f"{result.arm.name}: identified minus nominal, with 95 % intervals")
    figure.savefig(path, dpi=120, metadata={"Software": None})


def _fitness(search: GeneticTabuFit, poses: int, path: Path) -> None:
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    upper, lower = figure.add_subplot(2, 1, 1), figure.add_subplot(2, 1, 2)
    upper.semilogy(search.genetic.mean_costs / poses, color=BEFORE, label="mean of the population")
    upper.semilogy(search.genetic.best_costs / poses, color=AFTER, label="best")
    upper.set_xlabel("generation")
    lower.semilogy(search.tabu.current_costs / poses, color=BEFORE, label="current place of the search")
    lower.semilogy(search.tabu.best_costs / poses, color=AFTER, label="best so far")
    lower.set_xlabel("iteration of tabu search")
    for axes in (upper, lower):
        axes.set_ylabel("fitness a pose, mm")
        axes.grid(visible=True, alpha=0.3)
        axes.legend()
    figure.savefig(path, dpi=120, metadata={"Software": None})

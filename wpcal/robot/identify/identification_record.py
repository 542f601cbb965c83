"""`identification.json`: everything an identification found, as plain values.

Also here: charts of an identification, like figures 4 to 6 of Xiong, Yang, Wang 2015; they need matplotlib (`plots`).
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.error_field import error_field
from wpcal.robot.identify.error_summary import distances_mm, turns_deg
from wpcal.robot.identify.genetic_tabu import GeneticTabuFit
from wpcal.robot.identify.identification import Identification
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import Group
from wpcal.robot.kinematics.forward import LINK_SYMBOLS

IDENTIFICATION_SCHEMA = "wpcal/identification/1"


def identification_record(result: Identification) -> dict[str, Any]:
    """Return the record of an identification; lengths in mm, angles in degrees."""
    fit, options, observations = result.fit, result.options, result.observations
    joints = np.rad2deg(result.observations.joints[result.train])  # outside their range nothing is shown
    return {
        "schema": IDENTIFICATION_SCHEMA,
        "robot": result.arm.name,
        "robot_space": result.arm.space.value,
        "solver": options.solver.value,
        "seed": options.seed,
        "folds": options.folds,
        "verdict": asdict(result.verdict),
        "test_poses": {"before": result.before.to_record(), "after": result.after.to_record()},
        "whole_range": result.whole_range.to_record(),
        "error_field": _error_fields(result),
        "joints_deg": {"least": joints.min(axis=0).tolist(), "most": joints.max(axis=0).tolist()},
        "rows": {"train": _rows(observations, result.train), "test": _rows(observations, result.test)},
        "errors": _errors(result, observations),
        "rank": fit.rank,
        "asked": fit.rank + len(fit.unseen),
        "condition": fit.condition,
        "iterations": fit.iterations,
        "converged": fit.converged,
        "noise": {
            "sigma_mm": fit.noise.sigma_mm,
            "sigma_deg": float(np.rad2deg(fit.noise.sigma_rad)) if observations.has_orientations else None,
            "estimated": options.noise is None,
        },
        "parameters": parameter_rows(result),
        "covariance": {"names": [p.name for p in fit.parameters], "values_mm_rad": fit.covariance.tolist()},
        "outliers": [asdict(outlier) for outlier in result.outliers],
        "left_out": list(options.leave_out),
        "unseen": [{"name": unseen.name, "like": list(unseen.like)} for unseen in fit.unseen],
        "correlations": [
            {"first": first, "second": second, "value": value} for first, second, value in fit.strong_correlations()
        ],
        "T_measurement_base": _transform(measurement_base(result)) if options.free_base else None,
        "T_flange_tool": _transform(flange_tool(result))
        if options.free_tool and observations.has_orientations
        else None,
        "reflectors_flange_mm": _reflectors(result, observations) if options.free_tool else None,
        "search": _search(result),
        "issues": [issue.to_record() for issue in result.issues],
    }


def _error_fields(result: Identification) -> dict[str, Any]:
    """Return the smooth errors of the nominal and of the identified arm at the test poses."""
    places = result.observations.p_base[result.test]
    by_arm = {"nominal": result.errors_before, "identified": result.errors_after}
    fields = {arm: error_field(places, errors[:, -3:]) for arm, errors in by_arm.items()}
    return {arm: None if field is None else field.to_record() for arm, field in fields.items()}


def parameter_rows(result: Identification) -> list[dict[str, Any]]:
    """Return one row per link parameter: nominal and identified value, change and 95 % half width; mm or degrees.

    After `GENETIC_TABU` there is no half width: the search stops short of the minimum that the interval is about.
    """
    chain = result.arm.as_nominal().chain
    rows = []
    fit = result.fit
    for k, (parameter, step) in enumerate(zip(fit.parameters, fit.steps, strict=True)):
        if parameter.group is not Group.LINK:
            continue
        factor = 1.0 if parameter.is_length else float(np.rad2deg(1.0))
        nominal = float(chain.table[LINK_SYMBOLS.index(parameter.symbol), parameter.index])
        rows.append(
            {
                "name": parameter.name,
                "unit": "mm" if parameter.is_length else "deg",
                "nominal": factor * nominal,
                "identified": factor * (nominal + float(step)),
                "change": factor * float(step),
                "half_width_95": None if result.half_widths is None else factor * float(result.half_widths[k]),
                "absorbs": [unseen.name for unseen in fit.unseen if parameter.name in unseen.like],
            }
        )
    order = {"theta": 0, "d": 1, "beta": 1, "a": 2, "alpha": 3}
    return sorted(rows, key=lambda row: (order[row["name"].rstrip("0123456789")], row["name"]))


def measurement_base(result: Identification) -> RigidTransform:
    """Return the pose of the arm's base in the frame of the measurement (a tracker's)."""
    found, own = result.fit.model.chain.T_base_dh0, result.arm.chain.T_base_dh0
    T = found.matrix @ own.inverse().matrix
    return RigidTransform.from_matrix(T, target="measurement", source="base")


def flange_tool(result: Identification) -> RigidTransform:
    """Return how the measured body hangs on the flange."""
    found, own = result.fit.model.chain.T_dhn_flange, result.arm.chain.T_dhn_flange
    return RigidTransform.from_matrix(own.inverse().matrix @ found.matrix, target="flange", source="tool")


def _transform(T: RigidTransform) -> dict[str, Any]:
    return {"target": T.target, "source": T.source, "xyz_mm": T.t_mm.tolist(), "R": T.R.tolist()}


def _reflectors(result: Identification, observations: PoseObservations) -> dict[str, list[float]] | None:
    if observations.has_orientations:
        return None
    points = result.fit.model.reflectors_flange
    return {name or "reflector": point.tolist() for name, point in zip(observations.reflectors, points, strict=True)}


def _rows(observations: PoseObservations, indices: FloatArray | np.ndarray[tuple[int, ...], Any]) -> list[int]:
    return [observations.rows[int(i)] for i in indices]


def _errors(result: Identification, observations: PoseObservations) -> list[dict[str, Any]]:
    before_mm, after_mm = distances_mm(result.errors_before), distances_mm(result.errors_after)
    before_deg, after_deg = turns_deg(result.errors_before), turns_deg(result.errors_after)
    rows = []
    for i, row in enumerate(_rows(observations, result.test)):
        entry = {"row": row, "before_mm": float(before_mm[i]), "after_mm": float(after_mm[i])}
        if before_deg is not None and after_deg is not None:
            entry |= {"before_deg": float(before_deg[i]), "after_deg": float(after_deg[i])}
        rows.append(entry)
    return rows


def _search(result: Identification) -> dict[str, Any] | None:
    if result.search is None:
        return None
    genetic, tabu = result.search.genetic, result.search.tabu
    return {
        "genetic": {"cost_mm": genetic.cost, "evaluations": genetic.evaluations},
        "tabu": {
            "cost_mm": tabu.cost,
            "evaluations": tabu.evaluations,
            "forbidden": tabu.forbidden,
            "aspired": tabu.aspired,
        },
    }


BEFORE, AFTER = "#b35900", "#00527a"
"""Told apart in print and by readers who see no red or green."""


@style.context("default")  # not that of a matplotlibrc in the current folder, which could even start TeX
def write_charts(result: Identification, folder: Path) -> list[str]:
    """Write the charts as PNG files into a folder and return their names.

    `folder`: ``errors.png``: errors of the test poses before and after. ``parameters.png``: changes with 95 %
    intervals. ``fitness.png``: the search, where there was one.
    """
    names = ["errors.png", "parameters.png"]
    _charts_errors(result, folder / names[0])
    _parameters(result, folder / names[1])
    if result.search is not None:
        _fitness(result.search, len(result.train), folder / "fitness.png")
        names.append("fitness.png")
    return names


def _charts_errors(result: Identification, path: Path) -> None:
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

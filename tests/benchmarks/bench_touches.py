"""Errors of the seams after planned touches, relative to those after the best classical 3-2-1; simulated.

Classical means that the wire is held straight: its end meets the faces in front of it, its side the others. Among
these touches the best 3-2-1 is taken. Both are simulated with the wire as a cylinder against the displaced part
(`tests.touch_simulation`) and fitted, with the default errors of a cell and, in the last columns, with a stick-out that
is known, as after a touch on a post.
"""

import math
from dataclasses import replace

import numpy as np

from tests.touch_parts import touch_part
from tests.touch_simulation import Simulation
from wpcal.brep.material import ExactMaterial
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError, WpcalError
from wpcal.core.progress import no_progress
from wpcal.touch.plan import Pattern, TouchOptions, TouchPart, plan_touches
from wpcal.touch.plan.candidates import find_searches, thinned
from wpcal.touch.plan.part import PartPlace
from wpcal.touch.plan.patterns import choose_touches
from wpcal.touch.plan.plan_touches import design_of
from wpcal.touch.plan.searches_of import search_of
from wpcal.touch.searches import Search
from wpcal.touch.searches.setup import TouchSetup

PARTS = ("tee", "lap", "saddle", "frame", "gusseted-bracket", "post-base")
RUNS = 300
STRAIGHT = 0.1  #: A wire within 6 degrees of the normal or of the face is held straight.


def best_classical(part: TouchPart, options: TouchOptions) -> list[Search]:
    """Return the best 3-2-1 with the wire held straight."""
    options = replace(options, touches=6, pattern=Pattern.THREE_TWO_ONE)
    place = PartPlace.of(part.trimmed, np.array([0.0, 0.0, 1.0]))
    materials = [ExactMaterial(part.graph, part.trimmed)]
    found = find_searches(part.graph, part.trimmed, materials, place, options, no_progress)
    cos = found.strokes.contacts.cos_angle
    straight = found.strokes.select((cos < STRAIGHT) | (cos > 1.0 - STRAIGHT**2 / 2.0))
    strokes = thinned(straight, place)
    design = design_of(part, strokes, place, options)
    chosen = choose_touches(design, strokes.contacts.p, strokes.contacts.normal, options)
    none = np.empty((0, 3))
    return [search_of(part, strokes, int(row), f"T{k + 1}", none, options) for k, row in enumerate(chosen)]


def error_95_mm(errors: FloatArray) -> float:
    """Return the largest 95 % error over the points of the seams."""
    kept = errors[np.isfinite(errors).all(axis=1)]
    return float(np.quantile(kept, 0.95, axis=0).max())


def compared(part: TouchPart, setup: TouchSetup, runs: int = RUNS) -> tuple[float, float, float]:
    """Return predicted and simulated error of six planned touches, and the simulated error of the best 3-2-1, mm.

    That of a part without three plane sides is NaN.
    """
    options = TouchOptions(touches=6, setup=setup)
    plan = plan_touches(part, options=options)
    simulation = Simulation(setup, options.nominal)
    planned = error_95_mm(simulation.errors(part, plan.searches, runs))
    try:
        classical = error_95_mm(simulation.errors(part, best_classical(part, options), runs))
    except GeometryError:
        classical = math.nan
    return plan.predicted.error_95_mm, planned, classical


def main() -> None:
    """Print the table."""
    print("| part | predicted | planned | best 3-2-1 | ratio | ratio with a post |")
    print("|-|-|-|-|-|-|")
    for name in PARTS:
        predicted, planned, classical = compared(touch_part(name), TouchSetup())
        ratios = f"{planned / classical:.2f} | {with_a_post(name)}"
        print(f"| {name} | {predicted:.2f} | {planned:.2f} | {classical:.2f} | {ratios} |", flush=True)


def with_a_post(name: str) -> str:
    """Return the ratio of the last column, or why there is no plan."""
    try:
        _, planned, classical = compared(touch_part(name), TouchSetup(stick_out_sigma_mm=0.0))
    except WpcalError as error:
        return str(error)
    return f"{planned / classical:.2f}"

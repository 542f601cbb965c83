"""Lines and arcs of seams, against writing every point of the same seams: processor time of one run.

To reach: programs for 100 straight seams in at most 0.5 s, from the seams to the text of a language.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

from wpcal.controllers.program import WeldProgram, build_program
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.registry import controller_named
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

REPEATS = 3  #: The least of so many runs counts: other work on the machine only ever adds.
TO_REACH_S = 0.5
T = RigidTransform.identity(target="base", source="part")


def least_time(action: Callable[[], object]) -> float:
    """Shortest processor time of several runs, s."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        action()
        times.append(time.process_time() - start)
    return min(times)


def seam(name: str, p: FloatArray, R: FloatArray) -> Seam:
    """A seam with these frames."""
    index = np.zeros(1, dtype=np.int64)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    pieces = SeamPieces(index, np.zeros(1), np.zeros(1), index, index, np.zeros((1, 3)))
    frames = SeamFrames(s, p, R, np.ones(len(p)), "base")
    return Seam(name, JointType.TEE, WeldType.FILLET, (), pieces, False, float(s[-1]), True, True, (), frames)


def straight(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """30 to 400 mm, a point every 10 mm."""
    along = np.arange(0.0, rng.uniform(40.0, 400.0), 10.0)
    R = Rotation.random(rng=rng).as_matrix()
    return np.outer(along, R[:, 0]), np.tile(R, (len(along), 1, 1))


def saddle(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """A pipe on a pipe of random size, 40 points."""
    angle, big = np.linspace(0.0, 2.0 * np.pi, 40), rng.uniform(60.0, 120.0)
    out = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    height = np.sqrt(big**2 - (25.0 * np.sin(angle)) ** 2)
    slope = -(25.0**2) * np.sin(angle) * np.cos(angle) / height
    x = np.stack([-25.0 * np.sin(angle), 25.0 * np.cos(angle), slope], axis=1)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    z = out + np.stack([0 * angle, 25.0 * np.sin(angle), height], axis=1) / big
    z -= np.einsum("ij,ij->i", z, x)[:, None] * x
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.column_stack([25.0 * out[:, :2], height]), np.stack([x, np.cross(z, x), z], axis=2)


def main() -> Table:
    """One row per kind of seams."""
    rng = np.random.default_rng(0)
    heads = ("seams", "points", "moves", "fit s", "fit and RAPID s", "every point and RAPID s", "ratio")
    table = Table(title=f"Lines and arcs; 100 straight seams to reach: {TO_REACH_S} s")
    for heading in heads:
        table.add_column(heading, justify="right")
    write = controller_named("rapid").write
    for name, make, count in (("straight", straight, 100), ("saddles", saddle, 10)):
        seams = tuple(seam(f"W{number}", *make(rng)) for number in range(count))
        finished = FinishedCalibration(T, seams, (None,) * count, {})

        def build(finished: FinishedCalibration = finished) -> WeldProgram:
            return build_program(finished)

        program = build()
        fit = least_time(lambda program=program: fit_program(program))
        few = least_time(lambda build=build: write(fit_program(build())))
        every = least_time(lambda build=build: write(build()))
        points, moves = sum(map(len, program.paths)), sum(len(path.weld_moves) for path in fit_program(program).paths)
        row = (f"{count} {name}", str(points), str(moves), f"{fit:.3f}", f"{few:.3f}", f"{every:.3f}")
        table.add_row(*row, f"{few / every:.1f}")
    return table


if __name__ == "__main__":
    Console().print(main())

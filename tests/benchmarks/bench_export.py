"""Writing 10 000 poses in every format, against writing the same numbers with NumPy's own `savetxt`.

To reach: at most 0.5 s a format.
"""

import io

import numpy as np
from rich.table import Table
from scipy.spatial.transform import Rotation

from tests.benchmarks.timing import least_seconds
from wpcal.controllers.program import ControllerSettings, WeldPath, WeldProgram
from wpcal.controllers.registry import exporter_named, exporter_names
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

PATHS, POSES = 4, 2500
TO_REACH_S, REPEATS = 0.5, 3


def large_program() -> WeldProgram:
    """Four seams of 2500 random poses."""
    rng = np.random.default_rng(0)
    T = RigidTransform.from_six_tuple([800, -200, 150, 0.1, 0.2, 0.3], target="base", source="part")
    index, none = np.zeros(1, dtype=np.int64), np.zeros(1)
    pieces = SeamPieces(index, none, none, index, index, np.zeros((1, 3)))
    paths = []
    for number in range(PATHS):
        p, R = rng.uniform(-2000, 2000, (POSES, 3)), Rotation.random(POSES, rng=rng).as_matrix()
        frames = SeamFrames(np.arange(POSES - 2.0), p[1:-1], R[1:-1], np.ones(POSES - 2), "base")
        seam = Seam(f"W{number}", JointType.TEE, WeldType.FILLET, (), pieces, False, 1.0, True, True, (), frames)
        paths.append(WeldPath(seam, p, R, np.ones(POSES - 2)))
    controller = ControllerSettings(configurations={"fanuc": "N U T, 0, 0, 0", "inform": "1,0,0,0,0,0,0,0"})
    return WeldProgram(tuple(paths), T, controller=controller, calibration={"verdict": "PASS", "tolerance_mm": 0.5})


def main() -> Table:
    """One row a format."""
    program = large_program()
    poses = np.concatenate([path.p_base for path in program.paths])
    peer = least_seconds(lambda: np.savetxt(io.StringIO(), np.concatenate([poses, poses], axis=1), fmt="%.6f"), REPEATS)
    table = Table(title=f"Export of {PATHS * POSES} poses; numpy.savetxt of six numbers a row: {peer:.3f} s")
    for heading in ("format", "s", "times savetxt", f"at most {TO_REACH_S} s"):
        table.add_column(heading, justify="right")
    for name in exporter_names():
        exporter = exporter_named(name)
        try:
            seconds = least_seconds(lambda write=exporter.write: write(program), REPEATS)
        except InputError as error:  # FANUC takes 9999 lines
            table.add_row(name, "", "", str(error))
            continue
        table.add_row(name, f"{seconds:.3f}", f"{seconds / peer:.1f}", "yes" if seconds <= TO_REACH_S else "no")
    return table

"""Write docs/real-files.csv: results for STEP files made by others.

``python docs/make_real_parts.py FOLDER`` reads every STEP file of a folder, each in a process of its own, and takes the
least of three processor times. The calibration uses five features of the part, far from each other and moved by a known
pose.
"""

import csv
import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from cad.kernel.to_brep import to_brep
from cad.step.read import read_step
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.calibrate import calibrate
from wpcal.core.errors import WpcalError
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform
from wpcal.seam import SeamOptions
from wpcal.taught.features import find_features

TABLE = Path(__file__).with_name("real-files.csv")
REPEATS = 3
POINTS = 5
T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")
T = TypeVar("T")


def least(work: Callable[[], T]) -> tuple[T, float]:
    """Return what `work` returns and the least processor time of `REPEATS` runs, s."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        value = work()
        times.append(time.process_time() - start)
    return value, min(times)


def pose_error_mm(workpiece: Workpiece) -> float:
    """Largest error at any feature after a calibration from five of them."""
    p = np.array([feature.p_mm for feature in workpiece.features])
    rows = [int(np.argmax(np.linalg.norm(p - p.mean(axis=0), axis=1)))]
    while len(rows) < POINTS:
        rows.append(int(np.argmax(np.linalg.norm(p[:, None] - p[rows], axis=2).min(axis=1))))
    names = tuple(workpiece.features[row].name for row in rows)
    result = calibrate(PointPairs(names, p[rows], T_BASE_PART.apply(p[rows])))
    return float(np.linalg.norm(result.T_base_part.apply(p) - T_BASE_PART.apply(p), axis=1).max())


def measure(path: Path) -> dict[str, Any]:
    """Return one row of the table."""
    workpiece = open_workpiece(path)
    part, read_s = least(lambda: read_step(path))
    graph, brep_s = least(lambda: to_brep((solid.name, solid.shape) for solid in part.solids))
    features, features_s = least(lambda: find_features(graph))
    (seams, _), seams_s = least(lambda: find_seams(workpiece, SeamOptions()))
    kinds = Counter(feature.kind.value for feature in features)
    return {
        "solids": len(part.solids),
        "faces": graph.face_count,
        "features": " ".join(f"{kind} {count}" for kind, count in kinds.items()),
        "seams": len(seams),
        "accepted": sum(seam.accepted for seam in seams),
        "read s": f"{read_s:.2f}",
        "features s": f"{brep_s + features_s:.2f}",
        "seams s": f"{seams_s:.2f}",
        "pose off by mm": f"{pose_error_mm(workpiece):.0e}",
        "issues": ", ".join(dict.fromkeys(issue.code for issue in workpiece.issues)) or "none",
    }


def row(path: Path) -> dict[str, Any] | None:
    """Return the line of one file, measured in a process of its own; None for a refused file."""
    command = [sys.executable, __file__, "--one", str(path)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, timeout=600)
    return None if done.returncode else {"file": path.name, **json.loads(done.stdout.splitlines()[-1])}


def write_table(folder: Path) -> None:
    """Write the table of a folder."""
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in (".step", ".stp"))
    rows = [found for path in paths if (found := row(path))]
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: list[str]) -> int:
    """Write the table, or measure one file for it."""
    if arguments[0] != "--one":
        write_table(Path(arguments[0]))
        return 0
    try:
        print(json.dumps(measure(Path(arguments[1]))))
    except WpcalError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

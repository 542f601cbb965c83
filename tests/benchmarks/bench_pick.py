"""What the picker costs between a key and its answer, beside the bare fit of the same points; and its page.

The bare fit is `wpcal.calibrate.run` on pairs in hand. The picker's answer goes the whole way: JSON over HTTP,
the text of the table, names to features, the fit, the errors at every seam's frames, JSON back. The parts are
structures with hundreds of seams (`tests.samples.steel_structure`).
"""

import http.client
import json
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
from rich.table import Table

from cad.pick.draft import Keyed
from cad.pick.page import build_pick_page
from cad.pick.server import PickServer
from cad.pick.shared_table import SharedTable
from cad.session.part import PickPart, read_pick_part
from cad.session.rows import NEW_COLUMNS, Rows
from cad.session.session import PickSession
from cad.step.new_file import new_step_text
from cad.workpiece.seams import SeamChoice
from tests.benchmarks.timing import least_seconds
from tests.samples.steel_structure import steel_structure
from wpcal.calibrate import calibrate
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform
from wpcal.seam import SeamOptions
from wpcal.taught.features import FeatureKind

BAYS = (1, 10, 54)  #: The last has 10 000 faces.
POINTS = 6
REPEATS = 10
NOISE_MM = 0.2
T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")


def touched(part: PickPart) -> tuple[PointPairs, Rows]:
    """Some corners as a robot would show them, as pairs and as rows of the page."""
    rng = np.random.default_rng(7)
    corners = [f for f in part.workpiece.features if f.kind is FeatureKind.VERTEX]
    chosen = [corners[i] for i in rng.choice(len(corners), POINTS, replace=False)]
    p_part = np.array([corner.p_mm for corner in chosen])
    p_base = np.round(T_BASE_PART.apply(p_part) + rng.normal(0.0, NOISE_MM, p_part.shape), 2)
    names = tuple(corner.name for corner in chosen)
    cells = tuple((name, *(str(v) for v in p), name, "yes") for name, p in zip(names, p_base.tolist(), strict=True))
    return PointPairs(names, p_part, p_base), Rows(NEW_COLUMNS, cells)


def asking(server: PickServer, rows: Rows) -> Callable[[], object]:
    """Return what the page does after a pause of the typing hand."""
    place = urlsplit(server.url)
    headers = {"Origin": f"http://{place.netloc}", "Content-Type": "application/json"}
    connection = http.client.HTTPConnection(place.hostname or "", place.port)

    def ask() -> object:
        connection.request("POST", f"{place.path}fit", json.dumps(rows.to_record()), headers)
        answer = json.loads(connection.getresponse().read())
        if "answer" not in answer:
            raise RuntimeError(answer["fault"]["message"])
        return answer

    return ask


def row(bays: int, folder: Path) -> list[str]:
    """Measure one part."""
    path = folder / f"structure{bays}.step"
    path.write_bytes(new_step_text(steel_structure(bays), "structure", pcurves=False))
    part = read_pick_part(path, options=SeamOptions(), choice=SeamChoice())
    session = PickSession(part)
    pairs, rows = touched(part)
    frames = np.concatenate([seam.frames.p for seam in part.seams if seam.accepted])

    def build() -> str:
        return build_pick_page(part, session.options)

    server = PickServer(session, SharedTable(folder / "taught.csv", part, start=Keyed.of_rows(rows)), build())
    threading.Thread(target=server.run, daemon=True).start()
    bare = least_seconds(lambda: calibrate(pairs, seam_points=frames), REPEATS)
    whole = least_seconds(asking(server, rows), REPEATS)
    paging, size = least_seconds(build, 2), len(build()) / 1e6
    faces = str(len(part.workpiece.graph.face_solid))
    answers = (f"{1e3 * bare:.0f}", f"{1e3 * whole:.0f}", f"{whole / bare:.2f}")
    return [faces, str(len(frames)), *answers, f"{paging:.2f}", f"{size:.2f}"]


def main() -> Table:
    """Measure and return the table."""
    table = Table(title="wpcal pick: answer to a key, over the bare fit; and its page")
    for heading in ("faces", "seam frames", "bare fit ms", "answer ms", "ratio", "page s", "page MB"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory() as folder:
        for bays in BAYS:
            table.add_row(*row(bays, Path(folder)))
    return table

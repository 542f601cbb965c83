"""Three cluttered cells for moves through the air: boxes on all sides, a frame on a positioner, a narrow shelf."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.new_cell import NewCell, new_cell_files
from wpcal.planning.sequence.sequence_input import read_sequence_input

ROBOTS = Path(__file__).parents[2] / "shared" / "robots"  #: URDF files with meshes, beside the checkout.
FIXTURES = Path(__file__).parents[1] / "fixtures"
TOOL = (30.0, 0.0, 330.0, 0.0, 35.0, 0.0)  #: A bent torch: the tool centre point on the flange, mm and deg.
TRIED = 3000  #: Random states per round from which the free ones are taken.


class Clutter(NamedTuple):
    """A cell, and where in it one of every two states has the tip of its wire: corners in `world`, mm."""

    files: dict[str, dict[str, Any]]
    urdfs: dict[str, Path]
    part: str
    inside: tuple[FloatArray, FloatArray] | None


def place(values: tuple[float, ...], target: str, source: str) -> RigidTransform:
    record = {"xyz_mm": list(values[:3]), "rpy_deg": list(values[3:6]) if len(values) > 3 else [0, 0, 0]}
    return RigidTransform.from_record(record, target=target, source=source)


def new_cell(robot: str, **more: Any) -> tuple[dict[str, dict[str, Any]], dict[str, Path]]:
    """Return the files of a cell with the bodies of URDF files, and these files."""
    urdfs = {"robot": urdf(robot)}
    if "positioner" in more:
        urdfs["positioner"] = urdf(more["positioner"])
        more["positioner"] = str(urdfs["positioner"])
    base = more.pop("T_world_base", RigidTransform.identity(target="world", source="base"))
    tool = place(TOOL, "flange", "tool")
    new = NewCell(robot=str(urdfs["robot"]), T_world_base=base, T_flange_tool=tool, **more)
    return new_cell_files(new, "cell.json"), urdfs


def urdf(name: str) -> Path:
    return ROBOTS / name / f"{name}.urdf"


def boxes(seed: int = 0) -> Clutter:
    """Fourteen boxes around an IRB 2600, and the tee on a table."""
    rng = np.random.default_rng(seed)
    found = [(np.array([650.0, -400.0, 0.0]), np.array([1250.0, 400.0, 300.0]))]
    while len(found) < 15:
        turn, out = rng.uniform(-np.pi, np.pi), rng.uniform(650.0, 1500.0)
        middle = np.array([out * np.cos(turn), out * np.sin(turn), rng.uniform(200.0, 1900.0)])
        half = rng.uniform(60.0, 200.0, 3)
        found.append((middle - half, middle + half))
    files, urdfs = new_cell(
        "irb2600_12_165", boxes=found, T_carrier_part=place((900.0, -100.0, 310.0), "carrier", "part")
    )
    return Clutter(files, urdfs, "tee", None)


def positioner(seed: int = 0) -> Clutter:
    """A frame on a positioner with two axes, and a fence with a post between it and an MA2010."""
    walls = [
        (np.array([400.0, 700.0, 0.0]), np.array([1900.0, 740.0, 1800.0])),
        (np.array([350.0, -620.0, 0.0]), np.array([450.0, -520.0, 1300.0])),
        (np.array([900.0, -1100.0, 1500.0]), np.array([1700.0, -500.0, 1600.0])),
    ]
    files, urdfs = new_cell(
        "ma2010",
        T_world_base=place((0.0, 0.0, 505.0), "world", "base"),
        positioner="motopos_d500",
        T_world_positioner=place((1250.0, 0.0, 400.0), "world", "base"),
        T_carrier_part=place((-200.0, -150.0, 20.0), "carrier", "part"),
        boxes=walls,
    )
    return Clutter(files, urdfs, "frame", None)


def shelf(seed: int = 0) -> Clutter:
    """A shelf with six openings before a KR 5 arc; every other state has its wire in one of them."""
    x0, x1, t = 750.0, 1250.0, 20.0
    y, z = (-570.0, -190.0, 190.0, 570.0), (250.0, 720.0, 1190.0)
    boards = [(np.array([x0, y[0] - t, h - t]), np.array([x1, y[-1] + t, h + t])) for h in z]
    boards += [(np.array([x0, v - t, z[0]]), np.array([x1, v + t, z[-1]])) for v in y]
    boards.append((np.array([x1, y[0] - t, z[0]]), np.array([x1 + t, y[-1] + t, z[-1]])))
    files, urdfs = new_cell("kr5_arc", boxes=boards, T_carrier_part=place((900.0, -50.0, 760.0), "carrier", "part"))
    return Clutter(files, urdfs, "tee", (np.array([x0 + 60.0, y[0], z[0]]), np.array([x1, y[-1], z[-1]])))


CELLS: dict[str, Callable[..., Clutter]] = {"boxes": boxes, "positioner": positioner, "shelf": shelf}


def built(clutter: Clutter, folder: Path) -> tuple[Cell, CellClearance]:
    """Write the cell to a folder and read it as a user's."""
    for name, record in clutter.files.items():
        (folder / name).write_text(to_json(record), encoding="utf-8")
    cell = read_one_robot(folder / "cell.json")
    given = read_sequence_input(FIXTURES / clutter.part / "golden", cell)
    return cell, CellClearance(cell, given.part)


def free_pairs(clutter: Clutter, cell: Cell, clearance: CellClearance, count: int, seed: int) -> FloatArray:
    """Return pairs of random states that are free, shape (count, 2, k), within all limits."""
    rng = np.random.default_rng(seed)
    low, high = cell.limits
    found: list[list[FloatArray]] = [[], []]
    outer = 2 * count if clutter.inside is None else count // 2
    inner = 0 if clutter.inside is None else 2 * count - outer
    while len(found[0]) < outer or len(found[1]) < inner:
        q = rng.uniform(low, high, (TRIED, len(low)))
        if clutter.inside is not None:
            tip = cell.tool_places(q)[:, :3, 3]
            within = ((tip > clutter.inside[0]) & (tip < clutter.inside[1])).all(axis=1)
            found[1] += list(q[within][clearance.margins(q[within]).is_clear])
            q = q[:count]
        if len(found[0]) < outer:
            found[0] += list(q[clearance.margins(q).is_clear])
    return np.array([*found[0][:outer], *found[1][:inner]])[rng.permutation(2 * count)].reshape(count, 2, -1)

"""Plans of one robot on a bracket of about 30 seams: processor time of `plan` and `place`, with public URDF arms."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np
from rich.table import Table

from tests.running import run_here
from tests.samples.bench_bracket import write_bench_bracket
from wpcal.cli.part_option import read_part_option
from wpcal.core.records import to_json
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.new_cell import NewCell, new_cell_files
from wpcal.planning.sequence.place import map_places
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.torch.file import find_torch

ROBOTS = Path(__file__).parents[2].parent / "shared" / "robots"  #: URDF files, beside the clone; see its SOURCES.md.
ARMS = ("irb2600_12_165", "kr16_2", "m20ia")
NINE = ["W2", "W3", "W4", "W6", "W11", "W12", "W13", "W28", "W30"]  #: Seams of the cell with a positioner.
Result = TypeVar("Result")


def main() -> Table | None:
    """Return the table, or say that the arms are not there."""
    if not ROBOTS.is_dir():
        print(f"no arms in {ROBOTS}: nothing is timed")
        return None
    table = Table(title="Bracket, processor time")
    for heading in ("cell", "seams", "plan, s", "asked", "welded, mm", "of", "free", "place, s", "asked"):
        table.add_column(heading, justify="left" if heading == "cell" else "right")
    with TemporaryDirectory() as name:
        folder = Path(name)
        step = write_bench_bracket(folder)
        seams = folder / "seams.json"
        seams.write_text(run_here("seams", step, "--torch", "robot-22", "--json").stdout, encoding="utf-8")
        glb = read_part_option(step)
        for arm in ARMS:
            box = [(np.array([700.0, -350.0, 0.0]), np.array([1500.0, 550.0, 480.0]))]
            place = RigidTransform(rotation_from_zyx(0, 0, np.radians(30.0)), [1000, 50, 500], "world", "part")
            _add(table, _cell(folder, arm, place, boxes=box), seams, glb, None, (25, 20))
        at = RigidTransform(np.eye(3), [1300, 0, 380], "world", "base")
        on_table = RigidTransform(np.eye(3), [-210, -160, 60], "flange", "part")
        table_of_two = str(ROBOTS / "motopos_d500" / "motopos_d500.urdf")
        cell = _cell(folder, "gp25", on_table, positioner=table_of_two, T_world_positioner=at)
        _add(table, cell, seams, glb, NINE, (40, 20))
    return table


def _cell(folder: Path, arm: str, place: RigidTransform, **more: object) -> Cell:
    tool = RigidTransform(rotation_from_zyx(0, np.radians(40.0), 0), [60, 10, 370], "flange", "tool")
    urdf = str(ROBOTS / arm / f"{arm}.urdf")
    new = NewCell(
        robot=urdf,
        T_world_base=RigidTransform(np.eye(3), -find_arm(urdf).mount_mm, "world", "base"),
        T_flange_tool=tool,
        torch=find_torch("robot-22"),
        T_carrier_part=place,
        **more,
    )
    for name, record in new_cell_files(new, f"{arm}.json").items():
        (folder / name).write_text(to_json(record), encoding="utf-8")
    return read_one_robot(folder / f"{arm}.json")


def _add(
    table: Table, cell: Cell, seams: Path, glb: bytes | None, only: Sequence[str] | None, asked: tuple[int, int]
) -> None:
    given = read_sequence_input(seams, cell, only, part_glb=glb)
    cell, targets = given.placed(cell), SequenceTargets()
    plan_s, found = _timed(lambda: plan_sequence(cell, given.part, given.seams, targets).sequence)
    place_s, _ = _timed(lambda: map_places(cell, given.part, given.seams, targets))
    length = found.welded_mm + sum(gap.to_mm - gap.from_mm for gap in found.unwelded)
    numbers = (f"{plan_s:.1f}", f"≤ {asked[0]}", f"{found.welded_mm:.0f}", f"{length:.0f}")
    table.add_row(cell.name, str(len(given.seams)), *numbers, str(found.is_free), f"{place_s:.1f}", f"≤ {asked[1]}")


def _timed(work: Callable[[], Result]) -> tuple[float, Result]:
    start = time.process_time()
    found = work()
    return time.process_time() - start, found

"""Cells with one robot for tests: the shipped mh6 with the bodies of the cell of two, fixed part or positioner."""

import copy
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.saddle import CELLS
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import cell_from_record
from wpcal.planning.sequence.sequence_input import PlannedSeam
from wpcal.seam.seam import SeamFrames

TWO = json.loads((CELLS / "two-mh6.json").read_text(encoding="utf-8"))
TEE = CELLS.parent / "tee" / "golden"
HOME = [0.0, 10.0, -10.0, 0.0, -60.0, 0.0]


def positioner_record() -> dict[str, Any]:
    """Return an arm file of a positioner: axis 1 tilts about x of its base, axis 2 turns the table."""
    link = {"theta_deg": 0.0, "d_mm": 0.0, "a_mm": 0.0, "alpha_deg": 0.0, "parallel_to_next": False}
    turn = {"xyz_mm": [0, 0, 0], "rpy_deg": [0, 90, 0]}
    joint = {"sign": 1, "speed_deg_s": 90.0}
    return {
        "schema": "wpcal/arm/1",
        "name": "positioner",
        "robot_space": "nominal",
        "links": [{**link, "alpha_deg": -90.0}, {**link, "d_mm": 100.0}],
        "joints": [
            {**joint, "name": "tilt", "min_deg": -120.0, "max_deg": 120.0},
            {**joint, "name": "turn", "min_deg": -360.0, "max_deg": 360.0},
        ],
        "T_base_dh0": turn,
    }


def one_robot_record(**more: Any) -> dict[str, Any]:
    """Return the record of a cell with one mh6."""
    robot = copy.deepcopy(TWO["torch_robot"])
    return {
        "schema": "wpcal/cell/1",
        "name": "one mh6",
        "safety_distance_mm": 10,
        "torch_robot": {**robot, "home_deg": HOME},
        "T_world_part": None,
        **more,
    }


def write_cell(folder: Path, record: dict[str, Any]) -> Path:
    """Write a cell with the arm file of the positioner beside it."""
    (folder / "positioner.json").write_text(json.dumps(positioner_record()), encoding="utf-8")
    path = folder / "cell.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


TEE_ON_TABLE = (-75.0, -50.0, 10.0)  #: Where the tee is on the table of the positioner, flat side down.


def with_positioner(at: tuple[float, float, float] = (0.0, 0.0, 0.0), **more: Any) -> dict[str, Any]:
    """Return the record of a cell whose part is on a positioner in front of the robot."""
    place = {"xyz_mm": [900, 0, 500], "rpy_deg": [0, 0, 0]}
    part = {"xyz_mm": list(at), "rpy_deg": [0, 0, 0]}
    record = one_robot_record(
        positioner={"arm": "positioner.json", "T_world_base": place, "T_flange_part": part}, **more
    )
    del record["T_world_part"]
    return record


def fixed_cell(place: tuple[float, float, float] = (800.0, -100.0, 200.0)) -> Cell:
    """Return the cell with a part at a place in world."""
    frame = {"xyz_mm": list(place), "rpy_deg": [0, 0, 0]}
    return cell_from_record(one_robot_record(T_world_part=frame), path=CELLS / "cell.json")


def random_axes(cell: Cell, count: int, seed: int = 0) -> np.ndarray[Any, Any]:
    """Return axes within their limits."""
    low, high = cell.limits
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


def pipe_ring(like: PlannedSeam, radius_mm: float = 60.0, count: int = 73) -> PlannedSeam:
    """Return the fillet round a pipe that stands on a plate, about z of `part`; what is no geometry is as in a seam."""
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    x = np.column_stack([-np.sin(turn), np.cos(turn), np.zeros(count)])
    z = (out + np.array([0.0, 0.0, 1.0])) / np.sqrt(2.0)
    R = np.stack([x, np.cross(z, x), z], axis=2)
    frames = SeamFrames(radius_mm * turn, radius_mm * out, R, np.full(count, np.pi / 2))
    length = 2.0 * np.pi * radius_mm
    seam = dataclasses.replace(like.seam, name="R1", closed=True, length_mm=length, frames=frames, lean_rad=None)
    return PlannedSeam(seam)

"""What would help where a stretch cannot be welded: changes that were tried, and with which it is welded.

A change counts only if the whole stretch has a way in the changed cell: reach, limits, configuration and collisions,
and home is free. The changes are tried kind by kind, the smallest first. A quick look at the reach sorts out most of
them. The moves through the air to the stretch are not planned.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.same_bits import product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.shape import Shape
from wpcal.planning.sequence.external import external_axes
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import SeamTask
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.torch_poses import TorchPoses, torch_poses

TURNS_DEG = (15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0, 90.0, -90.0, 135.0, -135.0, 180.0)
MOVES_MM = (100.0, 200.0, 300.0, 400.0, 600.0)
RAISES_MM = (100.0, -100.0, 200.0, -200.0, 400.0, -400.0, 700.0)
FARTHER_MM = (150.0, 300.0, 500.0)
RANGES_DEG = (25.0, 35.0, 45.0)  #: Changes that are tried, the smallest first.
SIDES = 8  #: Directions in which the robot is moved.
SLIMMER = (0.8, 0.6)
"""Other torches that are tried: their bodies are this much thinner. The wire and the tool centre point stay."""
FULL_TRIES = 2
"""Changes of one kind that are searched with all collisions: each takes as long as the search of a seam."""
QUICK_AXES = 12  #: Positions of the external axes that are tried with a change: the most promising ones.
MOST_TOLD = 2  #: Changes that helped before and are told again for another stretch: each takes the search of a seam.
MOST_SEARCHED, MOST_WITH_POSITIONER = 6, 2
"""Stretches for which changes are looked for: a positioner multiplies what is tried. For the others only those are
tried that helped before."""


@dataclass(frozen=True, slots=True)
class Help:
    """A change with which a stretch is welded; it was tried."""

    text: str
    turn_deg: float = 0.0  #: Of the part about the vertical.
    move_mm: tuple[float, float] = (0.0, 0.0)  #: Of the robot in `world`: x and y.
    raise_mm: float = 0.0  #: Of the part, with its positioner.
    from_table_mm: float = 0.0  #: Of the part along z of the carrier: away from the table of its positioner.
    torch_range_deg: float | None = None  #: How far the torch may leave its target angles.
    torch_scale: float | None = None  #: Radius of another torch's bodies relative to those of this one.


@dataclass(slots=True)
class RemedySearch:
    """Looks for changes, and remembers those that helped."""

    search: SeamSearch  #: Of the cell as it is.
    _worked: list[Help] = field(default_factory=list)
    _searched: int = 0

    def find(self, stretch: SeamTask) -> tuple[tuple[Help, ...], bool]:
        """Return changes that help, and whether all kinds of changes were looked for."""
        found = list(islice((each for each in self._worked if self._welds(each, stretch)), MOST_TOLD))
        if found:
            return tuple(found), True
        most = MOST_SEARCHED if self.search.cell.carrier is None else MOST_WITH_POSITIONER
        if self._searched >= most:
            return (), False
        self._searched += 1
        poses = torch_poses(stretch, self.search.targets, self.search.clearance, tilted=True)
        is_torch_free = bool(poses.is_free.any(axis=1).all())
        for kind in _kinds(self.search.cell, is_torch_free=is_torch_free):
            hopeful = (each for each in kind if not is_torch_free or self._is_hopeful(each, stretch, poses))
            found += islice((each for each in islice(hopeful, FULL_TRIES) if self._welds(each, stretch)), 1)
        self._worked += [each for each in found if each not in self._worked]
        return tuple(found), True

    def _is_hopeful(self, help_: Help, stretch: SeamTask, poses: TorchPoses) -> bool:
        """Tell whether one branch reaches every rung, within limits and without singular poses."""
        if help_.torch_range_deg is not None or help_.torch_scale is not None:
            return True
        cell = changed_cell(self.search.cell, help_, self._centre())
        other = SeamSearch(cell, self.search.clearance, self.search.targets)
        values = external_axes(cell, stretch, self.search.targets).values[:1]
        _, usable = other.states(stretch, _fewer(poses), values)
        return bool(np.asarray(usable.any(axis=2)).all(axis=1).any())

    def _welds(self, help_: Help, stretch: SeamTask) -> bool:
        """Tell whether the whole stretch has a way with a change, and home is free."""
        cell = changed_cell(self.search.cell, help_, self._centre())
        clearance = CellClearance(cell, self.search.clearance.part, like=self.search.clearance)
        if not clearance.margins(cell.home[None]).is_clear[0]:
            return False
        search = SeamSearch(cell, clearance, changed_targets(self.search.targets, help_))
        is_torch = help_.torch_range_deg is not None or help_.torch_scale is not None
        return bool(search.whole(stretch, QUICK_AXES, (True,) if is_torch else (False,)))

    def _centre(self) -> FloatArray:
        """Return the middle of the part's box, mm in `part`; its origin without a part."""
        part = self.search.clearance.part
        if part is None:
            return np.zeros(3)
        return np.asarray((part.corners.min(axis=(0, 1)) + part.corners.max(axis=(0, 1))) / 2, dtype=np.float64)


def _kinds(cell: Cell, *, is_torch_free: bool) -> Iterator[Iterator[Help]]:
    """Yield the changes, kind by kind. If the torch itself is in the way, only another torch or other angles help."""
    if is_torch_free and cell.carrier is not None:
        yield (
            Help(f"the part {far:g} mm farther from the table of its positioner", from_table_mm=far)
            for far in FARTHER_MM
        )
    if is_torch_free:
        yield (Help(f"the part turned by {turn:g} deg about the vertical", turn_deg=turn) for turn in TURNS_DEG)
        yield (_moved(step, 2 * math.pi * side / SIDES) for step in MOVES_MM for side in range(SIDES))
        yield (Help(f"the part {'raised' if up > 0 else 'lowered'} by {abs(up):g} mm", raise_mm=up) for up in RAISES_MM)
    yield (Help(f"--torch-range-deg {most:g}", torch_range_deg=most) for most in RANGES_DEG)
    nozzles = [_across_mm(shape) for shape in cell.torch if shape.to_part_mm is not None]
    if nozzles:
        yield (_slimmer(max(nozzles), scale) for scale in SLIMMER)


def _across_mm(shape: Shape) -> float:
    """Return how far a nozzle reaches from the axis of the torch, z of `tool`: its capsules may lie around a hull."""
    around_mm = float(shape.radius_mm.max())
    return min(around_mm, float(np.hypot(*shape.hull.T[:2]).max())) if len(shape.hull) else around_mm


def _slim(shape: Shape, scale: float) -> Shape:
    """Return the capsules of a slimmer torch, those of a nozzle around its axis and not around its hull."""
    most_mm = np.inf if shape.to_part_mm is None else _across_mm(shape)
    return replace(shape, radius_mm=scale * np.minimum(shape.radius_mm, most_mm), hull=np.zeros((0, 3)))


def _slimmer(radius_mm: float, scale: float) -> Help:
    text = f"another torch, with a nozzle of {scale * radius_mm:.0f} mm radius instead of {radius_mm:.0f} mm"
    return Help(f"{text}, and a body as much slimmer", torch_scale=scale)


def _moved(step_mm: float, towards_rad: float) -> Help:
    x, y = (float(np.round(step_mm * way(towards_rad))) + 0.0 for way in (math.cos, math.sin))
    return Help(f"the robot moved by {x:.0f}, {y:.0f} mm in x, y of world", move_mm=(x, y))


def changed_targets(targets: SequenceTargets, help_: Help) -> SequenceTargets:
    """Return what a sequence is asked for after a change."""
    if help_.torch_range_deg is None:
        return targets
    return replace(targets, torch_range_rad=max(targets.torch_range_rad, math.radians(help_.torch_range_deg)))


def changed_cell(cell: Cell, help_: Help, centre: FloatArray) -> Cell:
    """Return a cell after a change. `centre`: shape (3,). What the part turns about, mm in `part`."""
    if help_.turn_deg:
        cell = _turned(cell, help_.turn_deg, centre)
    if any(help_.move_mm):
        cell = replace(cell, T_world_base=_shifted(cell.T_world_base, *help_.move_mm))
    if help_.raise_mm and cell.carrier is not None:
        place = _shifted(cell.carrier.T_world_base, z_mm=help_.raise_mm)
        cell = replace(cell, carrier=replace(cell.carrier, T_world_base=place))
    elif help_.raise_mm:
        cell = replace(cell, T_carrier_part=_shifted(cell.T_part, z_mm=help_.raise_mm))
    if help_.from_table_mm:
        cell = replace(cell, T_carrier_part=_shifted(cell.T_part, z_mm=help_.from_table_mm))
    if help_.torch_scale is not None:
        cell = replace(cell, torch=tuple(_slim(shape, help_.torch_scale) for shape in cell.torch))
    return cell


def _shifted(T: RigidTransform, x_mm: float = 0.0, y_mm: float = 0.0, z_mm: float = 0.0) -> RigidTransform:
    return replace(T, t_mm=T.t_mm + np.array([x_mm, y_mm, z_mm]))


def _turned(cell: Cell, turn_deg: float, centre: FloatArray) -> Cell:
    """Return the cell with the part turned about the vertical through a point of the part, in its carrier."""
    T = cell.part_places(cell.home[None])[0]
    pivot = np.asarray(product(T[:3, :3], centre) + T[:3, 3], dtype=np.float64)
    R = rotation_from_zyx(0.0, 0.0, np.radians(turn_deg))
    T_turn = RigidTransform(R, pivot - product(R, pivot), "world", "world")
    T_world_carrier = RigidTransform.from_matrix(
        cell.carrier_places(cell.home[None])[0], target="world", source="carrier"
    )
    part = cell.T_part.relabelled(target="carrier", source="part")
    return replace(cell, T_carrier_part=T_world_carrier.inverse() @ T_turn @ T_world_carrier @ part)


def _fewer(poses: TorchPoses) -> TorchPoses:
    """Keep the poses at the target torch angles where there are free ones at every rung."""
    on_target = poses.off_rad[0] == poses.off_rad.min()
    if not poses.is_free[:, on_target].any(axis=1).all():
        return poses
    return poses.select(slice(None), on_target)

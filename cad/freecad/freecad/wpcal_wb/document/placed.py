# SPDX-License-Identifier: MIT
"""The part where it really is: links to the user's objects in an `App::Part` at the pose in the robot's base.

The origin of the document is the origin of the robot's base there. The user's objects stay as and where they are. An
object whose solids moved differently cannot be linked: it is shown by a copy.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, Iterable, Mapping, NamedTuple, Sequence

import FreeCAD

from ..words import translate
from .export import is_same_placement
from .kinds import GROUP, HIDDEN, KIND
from .moved_solids import MovedSolid

FRAME_TYPES = (("PartDesign::CoordinateSystem", "PartDesign"), ("Part::LocalCoordinateSystem", "Part"))
"""Datum coordinate systems: the first type that this FreeCAD makes, and the module that must be loaded for it."""
MOST_FRAMES = 500
"""Each is an object of the tree, and thousands make FreeCAD slow. All frames can be drawn as one object instead."""
PLACED = "placed"  #: The kind of the `App::Part`: it is not exported with the model.


class NamedFrame(NamedTuple):
    """A seam frame with a name, in the coordinates of the part."""

    name: str
    placement: Any


def placed_part(document: Any) -> Any | None:
    """Return the part at its pose; None if the document has none."""
    found = (obj for obj in document.Objects if getattr(obj, KIND, "") == PLACED and obj.TypeId == "App::Part")
    return next(found, None)


def place_part(
    document: Any, objects: Sequence[Any], pose: Any, moved: Mapping[str, list[MovedSolid] | None] | None = None
) -> Any:
    """Show the part at its pose. Call it inside a `transaction`.

    Returns App::Part. With one link or copy per object. What it had of an earlier calibration is replaced.
    """
    part = placed_part(document)
    if part is None:
        part = document.addObject("App::Part", "WpCalPlaced")
        part.Label = translate("Part in the robot's base")
        _mark(part)
        if FreeCAD.GuiUp:  # Redo makes them visible otherwise
            for datum in (part.Origin, *part.Origin.OriginFeatures):
                datum.ViewObject.Visibility = False
    solids = {obj.Name: (moved or {}).get(obj.Name) or [] for obj in objects}
    copied = [obj for obj in objects if not _is_one_move(solids[obj.Name])]
    linked = {obj.Name: obj for obj in objects if obj not in copied}
    links = {obj.LinkedObject.Name: obj for obj in part.Group if obj.TypeId == "App::Link" and obj.LinkedObject}
    kept = [links[name] for name in links if name in linked]
    for old in [obj for obj in part.Group if obj.TypeId in ("App::Link", "Part::Feature") and obj not in kept]:
        document.removeObject(old.Name)
    for name, obj in linked.items():
        link = links.get(name) or _link(document, part, obj)
        move = solids[name][0].move if solids[name] else FreeCAD.Placement()
        if not is_same_placement(link.Placement, move):
            link.Placement = move
    for obj in copied:
        _copy(document, part, obj, solids[obj.Name])
    part.Placement = pose
    return part


def _is_one_move(solids: Sequence[MovedSolid]) -> bool:
    return all(is_same_placement(solids[0].move, solid.move) for solid in solids)


def _link(document: Any, part: Any, obj: Any) -> Any:
    link = document.addObject("App::Link", f"Placed_{obj.Name}")
    link.LinkedObject = obj
    link.LinkTransform = True  # the object keeps its place inside the part
    return _add(part, link, obj)


def _copy(document: Any, part: Any, obj: Any, solids: Sequence[MovedSolid]) -> None:
    import Part

    copy = document.addObject("Part::Feature", f"Placed_{obj.Name}")
    shapes = [solid.shape.copy() for solid in solids]
    for shape, solid in zip(shapes, solids):
        shape.Placement = solid.move.multiply(shape.Placement)
    copy.Shape = Part.makeCompound(shapes)
    if FreeCAD.GuiUp and hasattr(obj.ViewObject, "ShapeColor"):
        copy.ViewObject.ShapeColor = obj.ViewObject.ShapeColor
    _add(part, copy, obj)


def _add(part: Any, shown: Any, obj: Any) -> Any:
    shown.Label = translate("{label} in the base").format(label=obj.Label)
    _mark(shown)
    part.addObject(shown)
    return shown


def remove_placed(document: Any) -> None:
    """Remove the part at its pose, with its links and frames. The linked objects stay."""
    part = placed_part(document)
    if part is not None:
        remove_frames(document)
        for obj in list(part.Group):
            document.removeObject(obj.Name)
        document.removeObject(part.Name)


def seam_frames(seams: Iterable[Any], T_part_base: Any, *, ends_only: bool) -> list[NamedFrame]:
    """Return the frames of the accepted seams in the part."""
    found = []
    for seam in seams:
        if not seam["accepted"]:
            continue
        places, axes = seam["frames"]["p"], seam["frames"]["R"]
        rows = sorted({0, len(places) - 1}) if ends_only else range(len(places))
        for row in rows:
            T_base_seam = FreeCAD.Placement(FreeCAD.Vector(*places[row]), _rotation(axes[row]))
            found.append(NamedFrame(f"{seam['name']}_{row + 1}", T_part_base.multiply(T_base_seam)))
    return found


def add_frames(document: Any, part: Any, frames: Sequence[NamedFrame]) -> Any:
    """Add frames as datum coordinate systems to the placed part; those of an earlier call are replaced.

    Raises `ValueError` if there are more than `MOST_FRAMES`, or this FreeCAD has no datum coordinate systems.
    """
    if len(frames) > MOST_FRAMES:
        message = translate("{count} seam frames are too many for coordinate systems; at most {most}")
        raise ValueError(message.format(count=len(frames), most=MOST_FRAMES))
    remove_frames(document)
    group = document.addObject("App::DocumentObjectGroup", "WpCalFrames")
    group.Label = translate("Seam frames")
    _mark(group)
    part.addObject(group)
    for frame in frames:
        datum = _coordinate_system(document, frame.name)
        datum.Label = frame.name
        _mark(datum)
        datum.Placement = frame.placement
        group.addObject(datum)
    return group


def remove_frames(document: Any) -> None:
    """Remove the datum coordinate systems of the placed part."""
    part = placed_part(document)
    groups = [] if part is None else [obj for obj in part.Group if obj.TypeId == "App::DocumentObjectGroup"]
    for group in groups:
        for datum in list(group.Group):
            document.removeObject(datum.Name)
        document.removeObject(group.Name)


def _mark(obj: Any) -> None:
    """Mark an object as no part of the user's model."""
    obj.addProperty("App::PropertyString", KIND, GROUP, "What this object is")
    setattr(obj, KIND, PLACED)
    obj.setEditorMode(KIND, HIDDEN)


def _coordinate_system(document: Any, name: str) -> Any:
    for type_name, module in FRAME_TYPES:
        import_module(module)
        if type_name in document.supportedTypes():
            return document.addObject(type_name, f"Frame_{name}")
    raise ValueError(translate("this FreeCAD has no datum coordinate systems"))


def _rotation(axes: Sequence[Sequence[float]]) -> Any:
    (a, b, c), (d, e, f), (g, h, i) = axes
    return FreeCAD.Placement(FreeCAD.Matrix(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1)).Rotation

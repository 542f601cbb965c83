"""What a STEP document holds, counted, so that a written file can be compared with the one it came from."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_LayerTool, XCAFDoc_ShapeTool

from cad import kernel
from cad.kernel import KernelObject
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform

VERTEX_ATOL_MM = 1e-6
"""A thousandth of what a laser tracker resolves; appending reaches 1e-11, the kernel's writer 1e-9."""


@dataclass(frozen=True, slots=True, eq=False)
class StepInventory:
    """Counts of what is in a document.

    Parameters
    ----------
    surfaces : Counter
        Faces by kind of surface.
    vertices : ndarray, shape (n, 3)
        Distinct vertices, mm.
    names, colors, layers : Counter
        Labels by name, by colour and by layer.
    annotations : Counter
        Dimensions, tolerances and datums (PMI).
    """

    surfaces: Counter[str]
    vertices: FloatArray
    names: Counter[str]
    colors: Counter[tuple[float, float, float]]
    layers: Counter[str]
    annotations: Counter[str]


def take_inventory(document: KernelObject) -> StepInventory:
    """Count what a document holds.

    Parameters
    ----------
    document : kernel document

    Returns
    -------
    StepInventory
    """
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots = [XCAFDoc_ShapeTool.GetShape_s(label) for label in kernel.filled(tool.GetFreeShapes)]
    whole = kernel.compound([root for root in roots if not root.IsNull()])
    surfaces = Counter(kernel.surface_kind(face) for face in kernel.sub_shapes(whole, kernel.FACE))
    names: Counter[str] = Counter()
    colors: Counter[tuple[float, float, float]] = Counter()
    for label in kernel.filled(tool.GetShapes):
        for item in (label, *_below(label)):
            names[kernel.label_name(item)] += 1
            color = kernel.label_color(item)
            if color is not None:
                colors[color] += 1
    layers, annotations = _layers(document), _annotations(document)
    return StepInventory(surfaces, kernel.vertex_points(whole), names, colors, layers, annotations)


def _below(label: KernelObject) -> list[KernelObject]:
    """Components of an assembly, or labelled sub-shapes of a part."""
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        return kernel.filled(XCAFDoc_ShapeTool.GetComponents_s, label)
    return kernel.filled(XCAFDoc_ShapeTool.GetSubShapes_s, label)


def _layers(document: KernelObject) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
    return Counter(
        {
            kernel.label_name(layer): len(kernel.filled(XCAFDoc_LayerTool.GetShapesOfLayer_s, layer))
            for layer in kernel.filled(tool.GetLayerLabels)
        }
    )


def _annotations(document: KernelObject) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.DimTolTool_s(document.Main())
    fills: dict[str, Any] = {
        "dimensions": tool.GetDimensionLabels,
        "tolerances": tool.GetGeomToleranceLabels,
        "datums": tool.GetDatumLabels,
    }
    return Counter({name: len(kernel.filled(fill)) for name, fill in fills.items()})


def compare_inventories(
    before: StepInventory, after: StepInventory, T_base_part: RigidTransform, *, added: Counter[str]
) -> list[Issue]:
    """Differences between a file and its moved copy, as issues; empty when nothing was lost or changed.

    Parameters
    ----------
    before, after : StepInventory
        Of the file as read and of the file as written and read again.
    T_base_part : RigidTransform
        What the vertices were moved by.
    added : Counter
        Names that were added on purpose.

    Returns
    -------
    list of Issue
    """
    issues = [
        Issue(f"moved-{what}-differ", f"the written file differs in {what}: {_difference(old, new)}")
        for what, old, new in (
            ("faces", before.surfaces, after.surfaces),
            ("names", before.names + added, after.names),
            ("colors", before.colors, after.colors),
            ("layers", before.layers, after.layers),
            ("annotations", before.annotations, after.annotations),
        )
        if +old != +new
    ]
    return issues + _vertex_issues(T_base_part.apply(before.vertices), after.vertices)


def _difference(old: Counter[Any], new: Counter[Any]) -> str:
    """The keys whose counts differ, at most five of them."""
    keys = [key for key in dict.fromkeys([*old, *new]) if old[key] != new[key]]
    shown = ", ".join(f"{key}: {old[key]} before, {new[key]} after" for key in keys[:5])
    return shown + (f" and {len(keys) - 5} more" if len(keys) > 5 else "")


def _vertex_issues(expected: FloatArray, found: FloatArray) -> list[Issue]:
    if expected.shape != found.shape:
        counts = f"{len(expected)} vertices before, {len(found)} after"
        return [Issue("moved-vertices-differ", f"the written file differs in vertices: {counts}")]
    if not len(expected):
        return []
    worst = float(np.abs(expected - found).max())
    if worst > VERTEX_ATOL_MM:
        worst = _nearest(expected, found)  # the same points in another order are no difference
    if worst <= VERTEX_ATOL_MM:
        return []
    message = f"the written file's vertices are off the moved ones by {worst:.3g} mm (allowed {VERTEX_ATOL_MM:g})"
    return [Issue("moved-vertices-differ", message)]


def _nearest(expected: FloatArray, found: FloatArray) -> float:
    """Largest distance from a point of either set to the nearest of the other, mm."""
    from scipy.spatial import cKDTree

    there, back = cKDTree(found).query(expected)[0], cKDTree(expected).query(found)[0]
    return float(max(np.max(there), np.max(back)))

"""Count what a STEP document holds, to compare a written file with the file that was read."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_LayerTool, XCAFDoc_ShapeTool

from cad.kernel.call import KernelObject
from cad.kernel.geometry import edge_length, has_triangles_only, mesh_points, surface_kind, vertex_points
from cad.kernel.topology import EDGE, FACE, SHELL, VERTEX, compound, loose_shapes, sub_shape_uses, sub_shapes
from cad.kernel.xcaf import label_color, label_entry, label_name, labels_of, new_label
from cad.step.append_seams import SEAMS_NAME, SeamCurve
from cad.step.xcaf_tree import Leaf, StepTree, usable_name
from wpcal.brep.mesh import Rgb
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import short

VERTEX_ATOL_MM = 1e-6
"""A thousandth of what a laser tracker resolves. Appending is exact to 1e-11 mm, the kernel's writer to 1e-9 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class StepInventory:
    """What a document holds, counted."""

    surfaces: Counter[str]  #: Faces by kind of surface.
    vertices: FloatArray  #: shape (n, 3). Distinct vertices, and the nodes of faces that have triangles only, mm.
    #: `names`, `colors`, `layers`: Labels by name, by colour and by layer.
    names: Counter[str]
    colors: Counter[Rgb]
    layers: Counter[str]
    annotations: Counter[str]  #: Dimensions, tolerances and datums (PMI).


def take_inventory(document: KernelObject, *, without: str = "") -> StepInventory:
    """Count what a document holds."""
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    left_out = _entries_of(tool, without) if without else frozenset()
    whole = compound(_shapes(labels_of(tool.GetFreeShapes), left_out))
    faces = sub_shapes(whole, FACE)
    names: Counter[str] = Counter()
    colors: Counter[Rgb] = Counter()
    for label in labels_of(tool.GetShapes):
        if label_entry(label) in left_out:
            continue
        for item in (label, *(i for i in _below(label) if label_entry(_product(i)) not in left_out)):
            names[label_name(item)] += 1
            color = label_color(item)
            if color is not None:
                colors[color] += 1
    points = [vertex_points(whole), *(mesh_points(face) for face in faces if has_triangles_only(face))]
    surfaces = Counter(surface_kind(face) for face in faces)
    layers, annotations = _layers(document, without), _annotations(document)
    return StepInventory(surfaces, np.concatenate(points), names, colors, layers, annotations)


def cut_inventory(inventory: StepInventory, document: KernelObject) -> StepInventory:
    """Return what is left of the inventory of a document in an outline (`cad.step.outline`): one face of each shell."""
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    whole = compound(_shapes(labels_of(tool.GetFreeShapes), frozenset()))
    firsts = [face for shell in sub_shapes(whole, SHELL) for face, _ in islice(sub_shape_uses(shell, FACE), 1)]
    above = ((FACE, SHELL), (EDGE, FACE), (VERTEX, EDGE))
    cut = compound([*firsts, *(shape for kind, avoid in above for shape in loose_shapes(whole, kind, avoid))])
    surfaces = Counter(surface_kind(face) for face in sub_shapes(cut, FACE))
    return replace(inventory, surfaces=surfaces, vertices=vertex_points(cut))


def _product(label: KernelObject) -> KernelObject:
    """Product of a component; any other label is returned as it is."""
    product = new_label()
    return product if XCAFDoc_ShapeTool.GetReferredShape_s(label, product) else label


def _entries_of(tool: KernelObject, name: str) -> frozenset[str]:
    """Entries of the assemblies with a name and of their components' products."""
    found = set()
    for label in labels_of(tool.GetShapes):
        if label_name(label) == name:
            found.add(label_entry(label))
            found.update(label_entry(_product(component)) for component in _below(label))
    return frozenset(found)


def _shapes(roots: list[KernelObject], left_out: frozenset[str]) -> list[KernelObject]:
    """Shapes of the roots. Of a root with a component that is left out: its other components."""
    shapes: list[KernelObject] = []
    for root in roots:
        components = _below(root) if left_out else []
        kept = [item for item in components if label_entry(_product(item)) not in left_out]
        shapes.extend(XCAFDoc_ShapeTool.GetShape_s(item) for item in (kept if len(kept) < len(components) else [root]))
    return [shape for shape in shapes if not shape.IsNull()]


def _below(label: KernelObject) -> list[KernelObject]:
    """Components of an assembly, or labelled sub-shapes of a part."""
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        return labels_of(XCAFDoc_ShapeTool.GetComponents_s, label)
    return labels_of(XCAFDoc_ShapeTool.GetSubShapes_s, label)


def _layers(document: KernelObject, without: str) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
    named = ((label_name(layer), layer) for layer in labels_of(tool.GetLayerLabels))
    return Counter(
        {
            name: len(labels_of(XCAFDoc_LayerTool.GetShapesOfLayer_s, layer))
            for name, layer in named
            if not without or name != without
        }
    )


def _annotations(document: KernelObject) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.DimTolTool_s(document.Main())
    fills: dict[str, Any] = {
        "dimensions": tool.GetDimensionLabels,
        "tolerances": tool.GetGeomToleranceLabels,
        "datums": tool.GetDatumLabels,
    }
    return Counter({name: len(labels_of(fill)) for name, fill in fills.items()})


def compare_inventories(
    before: StepInventory, after: StepInventory, T_base_part: RigidTransform, *, added: Counter[str]
) -> list[Issue]:
    """Differences between a file and its moved copy. The list is empty when nothing was lost or changed."""
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
        worst = nearest_mm(expected, found)  # the order of the points does not matter
    if worst <= VERTEX_ATOL_MM:
        return []
    message = f"the written file's vertices are off the moved ones by {short(worst)} mm (allowed {VERTEX_ATOL_MM:g})"
    return [Issue("moved-vertices-differ", message)]


def nearest_mm(expected: FloatArray, found: FloatArray) -> float:
    """Largest distance from a point of either set, shapes (m, 3) and (n, 3), to the nearest of the other, mm."""
    from scipy.spatial import cKDTree

    there, back = cKDTree(found).query(expected)[0], cKDTree(expected).query(found)[0]
    return float(max(np.max(there), np.max(back)))


def compare_seam_edges(document: KernelObject, T_base_part: RigidTransform, seams: Sequence[SeamCurve]) -> list[Issue]:
    """Differences between seams and their edges in a document that was read again, length and its ends.."""
    found = {leaf.use.path[-1]: leaf for leaf in StepTree(document).leaves() if leaf.use.path[-2:-1] == (SEAMS_NAME,)}
    issues = []
    for seam in seams:
        leaf = found.get(usable_name(seam.name))
        what = "is missing" if leaf is None else _seam_difference(leaf, T_base_part, seam)
        if what:
            issues.append(Issue("moved-seams-differ", f"the written seam {seam.name} {what}", (seam.name,)))
    return issues


def _seam_difference(leaf: Leaf, T_base_part: RigidTransform, seam: SeamCurve) -> str:
    """What is wrong with the edge of a seam; empty when it is right."""
    edges = sub_shapes(leaf.shape.Moved(leaf.use.location), EDGE)
    if len(edges) != 1:
        return f"has {len(edges)} edges"
    points = T_base_part.apply(seam.points_part)
    length_mm = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    off_mm = abs(edge_length(edges[0]) - length_mm)
    ends = points[:1] if seam.is_closed else points[[0, -1]]
    off_mm = max(off_mm, nearest_mm(ends, vertex_points(edges[0])))
    return f"is off by {short(off_mm)} mm" if off_mm > VERTEX_ATOL_MM else ""

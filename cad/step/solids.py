"""The solids of one product: found, or sewn from loose faces. Oddities, such as open shells, are issues."""

from dataclasses import dataclass
from typing import Any

from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
from OCP.BRepCheck import BRepCheck_Shell, BRepCheck_Status
from OCP.BRepLib import BRepLib

from cad.kernel.call import KernelObject
from cad.kernel.geometry import has_triangles_only
from cad.kernel.topology import EDGE, FACE, SHELL, SOLID, ancestors, compound, loose_shapes, shell_of, sub_shapes
from wpcal.core.issue import Issue
from wpcal.core.wording import counted

SEWING_TOLERANCES_MM = (0.01, 0.03, 0.1)
"""Tried in this order until no edge is open. Above 0.1 mm, sewing moves edges by more than a robot's teaching error."""


@dataclass(frozen=True, slots=True, eq=False)
class LeafShapes:
    """The bodies of one product."""

    bodies: tuple[Any, ...]  #: Solids, or shells (closed or open) if there is no solid; in the product's own frame, mm.
    issues: tuple[Issue, ...]
    has_faces: bool  #: Whether the product has any face.


def leaf_shapes(name: str, shape: KernelObject) -> LeafShapes:
    """Find the solids of a product; sew its faces when it has none.

    `shape`: In the product's own frame, mm.
    Returns LeafShapes.
    """
    if shape.IsNull():
        return LeafShapes((), (Issue("empty-part", f"{name or 'a part'} has no shape", _ids(name)),), has_faces=False)
    faces = sub_shapes(shape, FACE)
    if not faces:
        edges = len(sub_shapes(shape, EDGE))
        what = f"no face but {edges} edges, which are given as marks" if edges else "no face: it may be in another file"
        issue = Issue("wires-only" if edges else "empty-part", f"{name or 'a part'} holds {what}", _ids(name))
        return LeafShapes((), (issue,), has_faces=False)
    issues: list[Issue] = []
    tessellated = sum(map(has_triangles_only, faces))
    if tessellated:
        issues.append(_tessellated_issue(name, tessellated, len(faces)))
    bodies = [] if tessellated == len(faces) else _bodies(name, shape, issues)
    loose_edges = len(loose_shapes(shape, EDGE, FACE))
    if loose_edges:
        message = f"{name or 'a part'}: {loose_edges} edges belong to no face (supplemental geometry or wires)"
        issues.append(Issue("free-edges", message, _ids(name)))
    return LeafShapes(tuple(bodies), tuple(issues), has_faces=True)


def _bodies(name: str, shape: KernelObject, issues: list[Issue]) -> list[KernelObject]:
    solids = sub_shapes(shape, SOLID)
    if not solids:
        return _sewn(name, shape, issues)
    loose = len(loose_shapes(shape, FACE, SOLID))
    if loose:
        message = f"{name or 'a part'}: {counted(loose, 'face')} outside of any solid: left out"
        issues.append(Issue("loose-faces", message, _ids(name)))
    _check(name, solids, issues)
    return solids


def _check(name: str, bodies: list[KernelObject], issues: list[Issue]) -> None:
    """Report bodies whose surface is not closed, or whose faces do not all point outwards."""
    invalid = sum(not all(map(_is_sound, sub_shapes(body, SHELL))) for body in bodies)
    if invalid:
        message = f"{name or 'a part'}: {invalid} of {len(bodies)} solids are not valid topology"
        issues.append(Issue("invalid-shape", message, _ids(name)))


def _is_sound(shell: KernelObject) -> bool:
    """Tell whether a shell is closed and oriented. The kernel's check of all sub-shapes takes thirty times as long."""
    check = BRepCheck_Shell(shell)
    found = check.Closed(False), check.Orientation(False)
    return all(status == BRepCheck_Status.BRepCheck_NoError for status in found)


def _sewn(name: str, shape: KernelObject, issues: list[Issue]) -> list[KernelObject]:
    """Make solids of a product of faces or shells: directly if its shells are closed, otherwise by sewing."""
    before = _open_edges(shape)
    shells = sub_shapes(shape, SHELL)
    if not before and shells and not loose_shapes(shape, FACE, SHELL):
        issues.append(_sewing_issue(name, f"{len(shells)} closed shells were made solids"))
        return _closed_as_solids([compound(shells)])
    tolerance, after, result = _best_sewing(shape)
    if after >= before and shells:
        issues.append(_sewing_issue(name, f"its surface is open ({before} open edges) and sewing does not close it"))
        return shells
    what = f"its faces were sewn with {tolerance:g} mm: {before} open edges before, {after} after"
    issues.append(_sewing_issue(name, what))
    return _closed_as_solids([result])


def _best_sewing(shape: KernelObject) -> tuple[float, int, KernelObject]:
    """Sew with the smallest tolerance that leaves no edge open, or with the one that leaves the fewest."""
    tried = []
    for tolerance in SEWING_TOLERANCES_MM:
        sewing = BRepBuilderAPI_Sewing(tolerance)
        sewing.Add(shape)
        sewing.Perform()
        result = sewing.SewedShape()
        after = _open_edges(result)
        tried.append((after, tolerance, result))
        if not after:
            break
    after, tolerance, result = min(tried, key=lambda item: item[:2])
    return tolerance, after, result


def _open_edges(shape: KernelObject) -> int:
    """Edges that one face only uses, and once."""
    count = 0
    for edge, faces in ancestors(shape, EDGE, FACE):
        if len(faces) == 1 and not BRep_Tool.Degenerated_s(edge) and not BRep_Tool.IsClosed_s(edge, faces[0]):
            count += 1
    return count


def _closed_as_solids(shapes: list[KernelObject]) -> list[KernelObject]:
    """Turn closed shells into solids with their material inside; open shells stay, loose faces become shells."""
    bodies = []
    for shape in shapes:
        for shell in sub_shapes(shape, SHELL):
            if not BRep_Tool.IsClosed_s(shell):
                bodies.append(shell)
                continue
            solid = BRepBuilderAPI_MakeSolid(shell).Solid()
            BRepLib.OrientClosedSolid_s(solid)
            bodies.append(solid)
        bodies.extend(shell_of(face) for face in loose_shapes(shape, FACE, SHELL))
    return bodies


def _sewing_issue(name: str, what: str) -> Issue:
    return Issue("unsewn-faces", f"{name or 'a part'} holds no solid; {what}", _ids(name))


def _ids(name: str) -> tuple[str, ...]:
    return (name,) if name else ()


def _tessellated_issue(name: str, count: int, total: int) -> Issue:
    """Report that `count` of the `total` faces of a product are tessellated; `name` is empty for a nameless product.

    Nothing is found on such faces (AP242). A part that has no others gives no solid; it can still be moved.
    `cad.kernel.to_brep` gives such a face the kind `SurfaceKind.NONE`.
    """
    what = "triangles only and no exact surface; nothing can be found on them"
    message = f"{name or 'a part'}: {count} of {total} faces have {what}"
    return Issue("tessellated-faces", message, (name,) if name else ())

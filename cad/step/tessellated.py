"""Faces that hold triangles only, as in tessellated AP242 files: recognised and reported.

wpcal finds no features or seams on such faces. A part of which all faces are tessellated gives no solid
(`cad.step.solids`); it can still be moved. `cad.kernel.to_brep` gives such a face the kind `SurfaceKind.NONE`.
"""

from __future__ import annotations

from collections.abc import Sequence

from cad.kernel.call import KernelObject
from cad.kernel.geometry import has_triangles_only
from wpcal.core.issue import Issue


def count_tessellated(faces: Sequence[KernelObject]) -> int:
    """Count the faces without an exact surface."""
    return sum(map(has_triangles_only, faces))


def tessellated_issue(name: str, count: int, total: int) -> Issue:
    """Report that `count` of the `total` faces of a product are tessellated; `name` is empty for a nameless product."""
    what = "triangles only and no exact surface; nothing can be found on them"
    message = f"{name or 'a part'}: {count} of {total} faces have {what}"
    return Issue("tessellated-faces", message, (name,) if name else ())

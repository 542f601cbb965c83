"""Write a moved part: by changing its own text, or, where that does not work, with the kernel's writer.

The written file is read again and compared with the file that was read. Every difference is an `Issue`. Of a large file
that was only appended to, the bytes are compared, and the kernel reads its outline (`cad.step.outline`).
"""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from numpy.typing import ArrayLike
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_DocumentTool

from cad.kernel.call import KernelObject, kernel_call, step_settings
from cad.kernel.geometry import to_location
from cad.kernel.xcaf import label_name, labels_of, to_extended_string
from cad.step.append import Placed, append_placement, with_entities
from cad.step.append_colors import with_solid_colors
from cad.step.append_seams import SEAMS_NAME, SeamCurve, append_seams
from cad.step.bake import bake_text
from cad.step.compare import StepInventory, compare_inventories, compare_seam_edges, cut_inventory, take_inventory
from cad.step.compare_solids import OwnMotions, take_solids
from cad.step.move_solids import move_solids
from cad.step.new_file import plain_step_text
from cad.step.outline import outline
from cad.step.part21 import Part21File, index_part21
from cad.step.read import StepPart, read_document, read_step
from wpcal.brep.mesh import Rgb
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import FormatError, KernelError
from wpcal.core.input_file import MOST_STEP_MB, read_bytes
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.records import write_file
from wpcal.core.transform import RigidTransform

DEFEATED = "moved-other-way"
DEFEATS = frozenset(
    {DEFEATED, "moved-faces-differ", "moved-vertices-differ", "moved-seams-differ", "moved-solids-differ"}
)
"""Differences in the geometry. After one of them the next way of writing is tried."""

MANY_FACES = 2000  #: With fewer faces, reading the whole file again takes less than a second or two.
LEAST_CUT = 2  #: An outline is worth reading if it holds this many times fewer faces.

SOME_MOVE = RigidTransform.from_six_tuple((812.5, -310.25, 455.125, 0.02, -0.3, 1.1), target="base", source="part")
"""A move with all six numbers, on which the checks of the moves of a part are tried."""

NOT_APART = "bodies-not-apart"  #: The bodies that moved could not be drawn apart.

WAY_NAMES = {
    "baked": "moving the geometry in the text",
    "appended": "appending to the text",
    "from_solids": "the kernel",
}
"""Ways of writing, for messages."""

SCHEMA_AP214, SCHEMA_AP242 = 4, 5
"""Values of the kernel's setting `write.step.schema`. With AP214 the kernel drops all annotations without a message."""

KERNEL_UNITS = {"um": "UM", "mm": "MM", "cm": "CM", "m": "M", "inch": "INCH", "ft": "FT"}
"""Values of the kernel's setting `write.step.unit`."""

Way: TypeAlias = "Callable[[StepInventory], tuple[bytes, Counter[str]]]"  #: Returns a text, and the names that it adds.


def write_moved_step(
    part: StepPart,
    T_base_part: RigidTransform,
    path: Path,
    *,
    bake: bool = False,
    seams: Sequence[tuple[str, ArrayLike, Rgb]] = (),
    known: KnownPart | None = None,
    T_part_moved: FloatArray | None = None,
) -> tuple[Issue, ...]:
    """Write a part moved by a rigid transform, then read the file again and compare.

    Returns tuple of Issue. Every way of writing that failed, and every difference in the file that was kept.
    Raises `InputError` when the file cannot be written, or a seam has fewer than two points.
    Raises `KernelError` when the kernel fails.

    `seams`: Polylines, shape (m, 3), in `part`, mm, with an sRGB colour, 0…1. They become named edges in a product
    ``wpcal seams``.
    `T_part_moved`: shape (n, 4, 4), optional. Where each of the n solids of the part has moved within `part`, mm,
    before the part is moved.

    Appending takes as long as copying the file. Checking takes as long as reading it did, or, where a file with many
    faces was appended to, a small part of that: all bytes of the file are still there, and one face of every solid is
    where it should be.
    """
    curves = tuple(SeamCurve(name, frozen(points), color) for name, points, color in seams)
    with kernel_call(f"writing {path}"):
        is_appended = not bake and T_part_moved is None
        known = known or KnownPart.of(part, least_faces=MANY_FACES if is_appended else math.inf)
        own = None if T_part_moved is None else OwnMotions(T_part_moved, take_solids(part))
    before = known.before
    # the shapes are not needed any more; if nobody else holds them, their memory is free for what is read again
    part = part.without_shapes()
    job = _Job(part, T_base_part, f"{Path(part.file_name).stem} calibrated", curves, known, own)
    issues: list[Issue] = []
    with kernel_call(f"writing {path}"):
        if own is not None:
            found, is_written = _tried(job, (*(job.baked,) * bake, job.appended, job.from_solids), path, before)
            if is_written:
                return found
            issues += [*found, Issue(NOT_APART, f"{path.name}: its bodies are drawn where the model has them")]
            job = replace(job, own=None)
        found, _ = _tried(job, (*(job.baked,) * bake, job.appended, job.from_document), path, before)
    return (*issues, *found)


def _tried(job: _Job, ways: Sequence[Way], path: Path, before: StepInventory) -> tuple[tuple[Issue, ...], bool]:
    """Write by the first way that succeeds; return what went wrong, and whether one did. The last file stays."""
    issues: list[Issue] = []
    for way in ways:
        try:
            text, added = way(before)
            write_file(path, text, overwrite=True)
            found = job.check(path, before, added, appended=way == job.appended)
        except FormatError as error:
            found = [Issue(DEFEATED, str(error))]
        is_right = not any(issue.code in DEFEATS for issue in found)
        if is_right or way == ways[-1]:
            return (*issues, *found), is_right
        issues.append(Issue(DEFEATED, f"{WAY_NAMES[way.__name__]} failed: {found[0].message}"))
    raise KernelError(f"writing {path}: no way of writing was tried")


@dataclass(frozen=True, slots=True, eq=False)
class KnownPart:
    """What was found of a part before it is moved."""

    before: StepInventory  #: What the kernel finds in the file.
    #: The outline of the file, if it is enough to check a moved one and much smaller, and what the kernel finds in it.
    outlined: tuple[Part21File, StepInventory] | None = None
    placed: Placed | None = None  #: Its roots.

    @classmethod
    def of(cls, part: StepPart, *, least_faces: float = 1) -> KnownPart:
        """Find what the kernel finds; the outline only if the file has this many faces."""
        before = take_inventory(part.document)
        if before.surfaces.total() < least_faces:
            return cls(before)
        cut = cut_inventory(before, part.document)
        if not 0 < LEAST_CUT * cut.surfaces.total() <= before.surfaces.total():
            return cls(before)
        with suppress(FormatError):
            return cls(before, (index_part21(outline(part.source), name=part.file_name), cut))
        return cls(before)


def know_part(part: StepPart) -> KnownPart:
    """Find what all moves of a part have in common, so that each of them takes a small part of the time.

    The part is moved once and the whole file is read again. If nothing differs, the outlines of the other moved files
    are read, as for a file of many faces.
    """
    with kernel_call(f"reading {part.file_name}"):
        known = KnownPart.of(part)
    part = part.without_shapes()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, Path(part.file_name).name)
        if write_moved_step(part, SOME_MOVE, path, known=KnownPart(known.before)):
            return KnownPart(known.before)
    with suppress(FormatError):
        return replace(known, placed=Placed.of(part.source))
    return KnownPart(known.before)


def write_moved_data(*, name: str, data: bytes, progress: Progress = no_progress, **settings: Any) -> tuple[Issue, ...]:
    """Write a STEP file of that name and those bytes, moved; the rest as in `write_moved_step`."""
    progress(f"reading {name}")
    part = read_step(name, data=data)
    progress("writing the moved part and reading it again")
    return write_moved_step(part, **settings)


@dataclass(frozen=True, slots=True)
class _Job:
    """What is to be written. Each method that writes returns the text and the names that it added."""

    part: StepPart
    T_base_part: RigidTransform
    name: str
    seams: tuple[SeamCurve, ...]
    known: KnownPart
    own: OwnMotions | None = None

    def appended(self, _before: StepInventory) -> tuple[bytes, Counter[str]]:
        """An assembly around the roots, appended to the text."""
        file, roots = self._with_own_motions()
        placed = None if self.own is not None else self.known.placed
        writer, assembly = append_placement(file, self.T_base_part, name=self.name, moves=roots, placed=placed)
        if self.seams:
            append_seams(writer, file, assembly, self.T_base_part, self.seams)
        return with_entities(file, writer), Counter(assembly.names)

    def baked(self, _before: StepInventory) -> tuple[bytes, Counter[str]]:
        """The geometry moved in the text."""
        file, roots = self._with_own_motions()
        if roots:
            raise FormatError("each of its solids stands alone and moves by itself: no assembly holds them")
        return self._with_seams(bake_text(file, self.T_base_part), Counter())

    def from_solids(self, _before: StepInventory) -> tuple[bytes, Counter[str]]:
        """Every solid as a product, placed by itself in one assembly, with the kernel's writer."""
        solids = read_step(self.part.file_name, data=self.part.text).solids
        if self.own is None or len(solids) != len(self.own.T_part_moved):
            raise FormatError("its solids are not those that moved", path=self.part.file_name)
        places = (self.T_base_part.matrix @ motion for motion in self.own.T_part_moved)
        placed = [
            (
                solid.name,
                BRepBuilderAPI_Copy(solid.shape.Located(TopLoc_Location())).Shape(),  # else one product for all uses
                to_location(RigidTransform.from_matrix(place, target="base", source="part")).Multiplied(
                    solid.shape.Location()
                ),
            )
            for solid, place in zip(solids, places, strict=True)
        ]
        text = plain_step_text(placed, self.name, pcurves=True)
        return self._with_seams(
            with_solid_colors(text, [solid.color_rgb for solid in solids], name=self.part.file_name), Counter()
        )

    def _with_own_motions(self) -> tuple[Part21File, dict[int, RigidTransform]]:
        """Return the text with the placements of solids that moved, and the motions of its roots."""
        if self.own is None:
            return self.part.source, {}
        text, roots = move_solids(self.part.source, self.part.leaves, self.own.T_part_moved)
        return index_part21(text, name=self.part.file_name), roots

    def from_document(self, before: StepInventory) -> tuple[bytes, Counter[str]]:
        """The kernel's document with its free shapes under one placed assembly."""
        text, added = _text_from_document(
            self.part, self.T_base_part, self.name, with_annotations=before.annotations.total() > 0
        )
        return self._with_seams(text, added)

    def _with_seams(self, text: bytes, added: Counter[str]) -> tuple[bytes, Counter[str]]:
        """Append the seams to a text whose part is already in `base`: both go into an assembly that moves nothing."""
        if not self.seams:
            return text, added
        file = index_part21(text, name=self.part.file_name)
        unmoved = RigidTransform.identity(target="base", source="part")
        writer, assembly = append_placement(file, unmoved, name=self.name)
        append_seams(writer, file, assembly, self.T_base_part, self.seams)
        return with_entities(file, writer), added + Counter(assembly.names)

    def check(self, path: Path, before: StepInventory, added: Counter[str], *, appended: bool) -> list[Issue]:
        """Read what was written and compare; first only its outline, if a large file was appended to."""
        if self.own is not None:
            again = read_step(path)
            found = self.own.compare(again, self.T_base_part, before, without=SEAMS_NAME)
            return found + compare_seam_edges(again.document, self.T_base_part, self.seams)
        if appended and self.known.outlined is not None:
            written, source = read_bytes(path, most_mb=MOST_STEP_MB), self.part.source
            head, tail = source.text[: source.data_end], source.text[source.data_end :]
            if not (written.startswith(head) and written.endswith(tail)):
                return [
                    Issue("moved-faces-differ", "the written file does not hold the text of the file that was read")
                ]
            if self._is_outline_right(path, written, *self.known.outlined, added):
                return []
        return self._compared(read_document(path), before, added)

    def _compared(self, document: KernelObject, before: StepInventory, added: Counter[str]) -> list[Issue]:
        after = take_inventory(document, without=SEAMS_NAME if self.seams else "")
        found = compare_inventories(before, after, self.T_base_part, added=added)
        return found + compare_seam_edges(document, self.T_base_part, self.seams)

    def _is_outline_right(
        self, path: Path, written: bytes, file: Part21File, cut: StepInventory, added: Counter[str]
    ) -> bool:
        """Tell whether what was added to a file places its outline right; False if an outline lacks more than faces."""
        source, text, end = self.part.source, file.text, file.data_end
        new = written[source.data_end : len(written) - len(source.text) + source.data_end]
        try:
            return not self._compared(read_document(path, text[:end] + new + text[end:]), cut, added)
        except FormatError:
            return False


def _text_from_document(
    part: StepPart, T_base_part: RigidTransform, name: str, *, with_annotations: bool
) -> tuple[bytes, Counter[str]]:
    """Write the free shapes under one placed assembly with the kernel's writer; return the names added as well."""
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "moved.step"
        document = read_document(Path(part.file_name), part.text)  # a copy: the part's own document is not changed
        added = _wrap_free_shapes(document, T_base_part, name)
        _write_document(document, written, part, with_annotations=with_annotations)
        return written.read_bytes(), added


def _wrap_free_shapes(document: KernelObject, T_base_part: RigidTransform, name: str) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    free = labels_of(tool.GetFreeShapes)
    top = tool.NewShape()
    TDataStd_Name.Set_s(top, to_extended_string(name))
    added = Counter([name])
    for label in free:
        component = tool.AddComponent(top, label, to_location(T_base_part))
        text = label_name(label) or name
        TDataStd_Name.Set_s(component, to_extended_string(text))
        added[text] += 1
    tool.UpdateAssemblies()
    return added


def _write_document(document: KernelObject, path: Path, part: StepPart, *, with_annotations: bool) -> None:
    """Write an XCAF document in the part's unit and with the part's own time stamp.

    The writer returns RetError for files with annotations that read back well. Therefore its status is ignored: the
    file is read again and compared.
    """
    settings: dict[str, int | str] = {
        "write.stepcaf.subshapes.name": 1,
        "write.step.schema": SCHEMA_AP242 if with_annotations else SCHEMA_AP214,
        "write.step.unit": KERNEL_UNITS.get(part.unit, "MM"),
    }
    with step_settings(settings):
        writer = STEPCAFControl_Writer()
        for switch in (writer.SetNameMode, writer.SetColorMode, writer.SetLayerMode, writer.SetDimTolMode):
            switch(True)
        writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
        header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
        header.SetTimeStamp(TCollection_HAsciiString(part.source.time_stamp))
        writer.Write(str(path))
    if not path.exists():
        raise KernelError(f"{part.file_name}: the CAD kernel wrote no file")

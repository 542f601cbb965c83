"""Write a part moved: by appending to its own text, or where that is defeated from the kernel's document.

The written file is read again and compared with what was read; every difference is an `Issue`.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from pathlib import Path

from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.XCAFDoc import XCAFDoc_DocumentTool

from cad import kernel
from cad.append_step import append_placement, with_entities
from cad.compare_step import StepInventory, compare_inventories, take_inventory
from cad.read_step import StepPart, read_document
from wpcal.core.errors import FormatError, KernelError
from wpcal.core.issue import Issue
from wpcal.core.records import write_file
from wpcal.core.transform import RigidTransform

NOT_APPENDED = "moved-not-appended"
DEFEATS = frozenset({NOT_APPENDED, "moved-faces-differ", "moved-vertices-differ"})
"""Differences after which the appended file is given up: its geometry is not where it should be."""

SCHEMA_AP214, SCHEMA_AP242 = 4, 5
"""Values of the kernel's `write.step.schema`; with AP214 it drops all annotations and says nothing."""

KERNEL_UNITS = {"um": "UM", "mm": "MM", "cm": "CM", "m": "M", "inch": "INCH", "ft": "FT"}
"""Values of the kernel's `write.step.unit`."""


def write_moved_step(part: StepPart, T_base_part: RigidTransform, path: Path) -> tuple[Issue, ...]:
    """Write a part moved by a rigid transform, then read the file again and compare.

    Parameters
    ----------
    part : StepPart
    T_base_part : RigidTransform
    path : Path
        Overwritten when it exists.

    Returns
    -------
    tuple of Issue
        How it was written when not by appending, and every difference found.

    Raises
    ------
    InputError
        When the file cannot be written.
    KernelError
        When the kernel fails.

    Notes
    -----
    Appending costs a copy of the file; reading it again costs as much as reading it did.
    """
    name = f"{Path(part.file_name).stem} calibrated"
    with kernel.kernel_call(f"writing {path}"):
        before = take_inventory(part.document)
        try:
            writer, assembly = append_placement(part.source, T_base_part, name=name)
            write_file(path, with_entities(part.source, writer), overwrite=True)
            found = _reread(before, T_base_part, path, Counter(assembly.names))
        except FormatError as error:
            found = [Issue(NOT_APPENDED, f"its text could not be appended to: {error}")]
        if not any(issue.code in DEFEATS for issue in found):
            return tuple(found)
        reason = Issue(NOT_APPENDED, f"written anew by the CAD kernel instead: {found[0].message}")
        added = _write_from_document(part, T_base_part, path, name, with_annotations=before.annotations.total() > 0)
        return (reason, *_reread(before, T_base_part, path, added))


def _reread(before: StepInventory, T_base_part: RigidTransform, path: Path, added: Counter[str]) -> list[Issue]:
    after = take_inventory(read_document(path))
    return compare_inventories(before, after, T_base_part, added=added)


def _write_from_document(
    part: StepPart, T_base_part: RigidTransform, path: Path, name: str, *, with_annotations: bool
) -> Counter[str]:
    """Write the free shapes under one placed assembly with the kernel's writer; return the names that were added."""
    with tempfile.TemporaryDirectory() as folder:
        original = Path(folder) / "part.step"
        original.write_bytes(part.text)
        document = read_document(original)  # a copy: the part's own document is not changed
        added = _wrap_free_shapes(document, T_base_part, name)
        written = Path(folder) / "moved.step"
        _write_document(document, written, part, with_annotations=with_annotations)
        write_file(path, written.read_bytes(), overwrite=True)
    return added


def _wrap_free_shapes(document: kernel.KernelObject, T_base_part: RigidTransform, name: str) -> Counter[str]:
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    free = kernel.filled(tool.GetFreeShapes)
    top = tool.NewShape()
    TDataStd_Name.Set_s(top, kernel.extended(name))
    added = Counter([name])
    for label in free:
        component = tool.AddComponent(top, label, kernel.to_location(T_base_part))
        text = kernel.label_name(label) or name
        TDataStd_Name.Set_s(component, kernel.extended(text))
        added[text] += 1
    tool.UpdateAssemblies()
    return added


def _write_document(document: kernel.KernelObject, path: Path, part: StepPart, *, with_annotations: bool) -> None:
    """Write an XCAF document in the part's unit and with the part's own time stamp.

    The writer says RetError of files with annotations that read back well, so its status is not asked: the file is read
    again and compared.
    """
    Interface_Static.SetIVal_s("write.stepcaf.subshapes.name", 1)
    Interface_Static.SetIVal_s("write.step.schema", SCHEMA_AP242 if with_annotations else SCHEMA_AP214)
    Interface_Static.SetCVal_s("write.step.unit", KERNEL_UNITS.get(part.unit, "MM"))
    writer = STEPCAFControl_Writer()
    for switch in (writer.SetNameMode, writer.SetColorMode, writer.SetLayerMode, writer.SetDimTolMode):
        switch(True)
    writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetTimeStamp(TCollection_HAsciiString(part.source.time_stamp))
    writer.Write(str(path))
    if not path.exists():
        raise KernelError(f"{part.file_name}: the CAD kernel wrote no file")

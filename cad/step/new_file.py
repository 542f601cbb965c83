"""A new STEP file of named, coloured solids: the same bytes in every run."""

import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TDataStd import TDataStd_Name
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_DocumentTool

from cad.kernel.call import KernelObject, kernel_call, step_settings
from cad.kernel.xcaf import new_document, srgb, to_extended_string
from cad.step.append_colors import with_solid_colors

Member: TypeAlias = tuple[str, KernelObject, tuple[float, float, float]]
"""Name, kernel solid and colour (linear RGB, 0…1)."""

FIXED_TIME = "2026-01-01T00:00:00"  #: The time in the header of every file, so that the same solids give the same file.


def new_step_text(members: Sequence[Member], name: str, *, pcurves: bool = True) -> bytes:
    """Return solids as an assembly in a STEP file (AP214, mm) with names and colours.

    Raises `KernelError` when the kernel fails.

    `pcurves`: Whether each edge is also written as a curve in the parameters of its faces. This kernel does so by
    default; most CAD systems do not.
    """
    placed = [(member, shape, TopLoc_Location()) for member, shape, _ in members]
    text = plain_step_text(placed, name, pcurves=pcurves)
    header = rb"FILE_NAME('%s','%s',('wpcal'),('wpcal'),'','wpcal samples','');" % (name.encode(), FIXED_TIME.encode())
    text = re.sub(rb"FILE_NAME\(.*?\);", header, text, count=1, flags=re.DOTALL)
    return with_solid_colors(text, [srgb(rgb) for _, _, rgb in members], name=name)


def plain_step_text(placed: Sequence[tuple[str, KernelObject, KernelObject]], name: str, *, pcurves: bool) -> bytes:
    """Return solids as an assembly in a STEP file without colours; the rest as in `new_step_text`.

    `placed`: sequence of (name, kernel solid, kernel location).
    """
    document = new_document()
    settings = {"write.surfacecurve.mode": int(pcurves)}
    with tempfile.TemporaryDirectory() as folder, kernel_call(f"writing {name}"), step_settings(settings):
        _fill(document, placed, name)
        writer = STEPCAFControl_Writer()
        writer.SetNameMode(True)
        writer.SetColorMode(False)
        writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
        path = Path(folder) / "part.step"
        writer.Write(str(path))
        return path.read_bytes()


def _fill(document: KernelObject, placed: Sequence[tuple[str, KernelObject, KernelObject]], name: str) -> None:
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    top = shapes.NewShape()
    TDataStd_Name.Set_s(top, to_extended_string(name))
    for member, shape, location in placed:
        label = shapes.AddShape(shape, False)
        TDataStd_Name.Set_s(label, to_extended_string(member))
        instance = shapes.AddComponent(top, label, location)
        TDataStd_Name.Set_s(instance, to_extended_string(member))
    shapes.UpdateAssemblies()

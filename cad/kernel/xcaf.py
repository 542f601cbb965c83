"""Labels of an XCAF document (the kernel's tree of products, instances and attributes): names, colours, entries."""

from __future__ import annotations

from typing import Any

from OCP.collections import Sequence_TDF_Label
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_Tool
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

from cad.kernel.call import KernelObject
from wpcal.brep.mesh import Rgb


def to_extended_string(text: str) -> KernelObject:
    """Kernel string of a text; without the flag the kernel reads UTF-8 as Latin-1."""
    return TCollection_ExtendedString(text, True)


def labels_of(fill: Any, *arguments: KernelObject) -> list[KernelObject]:
    """Call a kernel method that fills a sequence of labels, its last argument, and return the labels."""
    sequence = Sequence_TDF_Label()
    fill(*arguments, sequence)
    return [sequence.Value(i) for i in range(1, sequence.Upper() + 1)]  # Length() takes 0.2 ms


def label_name(label: KernelObject) -> str:
    """Name of a label as written; empty when it has none."""
    guid = TDataStd_Name.GetID_s()
    if not label.IsAttribute(guid):  # FindAttribute would crash the interpreter
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(guid, attribute)
    return str(attribute.Get().ToExtString())


def label_entry(label: KernelObject) -> str:
    """Place of a label in its document: ``0:1:1:3``."""
    text = TCollection_AsciiString()
    TDF_Tool.Entry_s(label, text)
    return str(text.ToCString())


def new_document() -> KernelObject:
    """Return an empty XCAF document: the kernel's tree of products, instances and attributes."""
    document = TDocStd_Document(to_extended_string("XmlXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    return document


def new_label() -> KernelObject:
    """Return an empty label, for kernel methods that fill one."""
    return TDF_Label()


_COLOR_TYPES = (
    XCAFDoc_ColorType.XCAFDoc_ColorSurf,
    XCAFDoc_ColorType.XCAFDoc_ColorGen,
    XCAFDoc_ColorType.XCAFDoc_ColorCurv,
)
_COLOR_DIGITS = 4  #: The kernel stores colours as linear float32; converting there and back changes the sixth digit.


def srgb(linear: tuple[float, float, float]) -> Rgb:
    """Return a linear colour as a file writes it (sRGB, 0…1)."""
    return _srgb(Quantity_Color(*linear, Quantity_TypeOfColor.Quantity_TOC_RGB))


def _srgb(color: KernelObject) -> Rgb:
    r, g, b = (round(float(v), _COLOR_DIGITS) for v in color.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB))
    return r, g, b


def label_color(label: KernelObject) -> Rgb | None:
    """Colour of a label as the file writes it (sRGB, 0…1): of its surface, else in general, else of its curve."""
    color = Quantity_Color()
    for kind in _COLOR_TYPES:
        if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
            return _srgb(color)
    return None

"""Small STEP files made with the kernel's own writer, for the tests of reading and writing."""

from pathlib import Path

from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Pnt
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from cad.kernel.geometry import to_location
from cad.kernel.topology import FACE, compound, sub_shapes
from cad.kernel.xcaf import to_extended_string
from wpcal.core.transform import RigidTransform

SECOND_USE = RigidTransform.from_six_tuple([100.0, 20.0, 5.0, 0.1, 0.2, 0.3], target="part", source="product")
"""Where the assembly sample places its box the second time."""


def box(corner=(0.0, 0.0, 0.0), size=(30.0, 20.0, 10.0)):
    return BRepPrimAPI_MakeBox(gp_Pnt(*corner), *size).Shape()


def cylinder():
    return BRepPrimAPI_MakeCylinder(5.0, 40.0).Shape()


def unsewn_box():
    """Six faces that share no edge and look inwards."""
    faces = [BRepBuilderAPI_Copy(face).Shape().Reversed() for face in sub_shapes(box(), FACE)]
    return compound(faces)


def open_box():
    """Five sides of a box as one shell-less set of shared faces."""
    return compound(sub_shapes(box(), FACE)[:5])


def new_document():
    STEPCAFControl_Controller.Init_s()
    XCAFDoc_ShapeTool.SetAutoNaming_s(False)
    document = TDocStd_Document(to_extended_string("XmlXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    return document


def add_part(document, shape, name, color=None):
    label = XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).AddShape(shape, False)
    TDataStd_Name.Set_s(label, to_extended_string(name))
    if color is not None:
        tool = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        rgb = Quantity_Color(*color, Quantity_TypeOfColor.Quantity_TOC_sRGB)
        tool.SetColor(label, rgb, XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    return label


def write_document(document, path: Path, unit: str = "MM") -> Path:
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer = STEPCAFControl_Writer()
    writer.SetNameMode(True)
    writer.SetColorMode(True)
    from OCP.STEPControl import STEPControl_StepModelType

    writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return path


def write_part(path: Path, shape, name="plate", color=(1.0, 0.5, 0.25), unit="MM") -> Path:
    document = new_document()
    add_part(document, shape, name, color)
    return write_document(document, path, unit)


def write_assembly(path: Path, unit="MM") -> Path:
    """Frame: the box ``Träger 'A'`` twice, and a nameless cylinder."""
    document = new_document()
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    beam = add_part(document, box(), "Träger 'A'", (1.0, 0.5, 0.25))
    pin = add_part(document, cylinder(), "")
    top = tool.NewShape()
    TDataStd_Name.Set_s(top, to_extended_string("frame"))
    identity = RigidTransform.identity(target="part", source="product")
    for label, name, place in ((beam, "left", identity), (beam, "right", SECOND_USE), (pin, "pin", identity)):
        component = tool.AddComponent(top, label, to_location(place))
        TDataStd_Name.Set_s(component, to_extended_string(name))
    tool.UpdateAssemblies()
    return write_document(document, path, unit)

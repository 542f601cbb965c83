"""Run by `freecadcmd -t`: a document is written, opened without the workbench, and opened with it again.

`WPCAL_TEST_STEP` names the step. Each step is a FreeCAD of its own.
"""

import os
import unittest
from pathlib import Path

import FreeCAD

STEP = os.environ["WPCAL_TEST_STEP"]
FILE = Path(os.environ["WPCAL_TEST_FOLDER"]) / "kept.FCStd"
SEAMS = '{"seams":[{"name":"W1 „außen“"}]}'


class SavingTest(unittest.TestCase):
    @unittest.skipUnless(STEP == "write", STEP)
    def test_write(self) -> None:
        from freecad.wpcal_wb.document import kinds

        document = FreeCAD.newDocument()
        box = document.addObject("Part::Box", "Box")
        seams = kinds.make_object(document, kinds.Kind.SEAMS)
        seams.Objects, seams.Seams = [box], SEAMS
        seams.PartFrame = FreeCAD.Placement(FreeCAD.Vector(1, 2, 3), FreeCAD.Rotation())
        kinds.make_object(document, kinds.Kind.TAUGHT)
        kinds.make_object(document, kinds.Kind.CALIBRATION)
        document.recompute()
        document.saveAs(str(FILE))

    @unittest.skipUnless(STEP == "without", STEP)
    def test_without_the_workbench_the_data_are_there_and_survive_saving(self) -> None:
        with self.assertRaises(ImportError):
            __import__("freecad.wpcal_wb")
        document = FreeCAD.openDocument(str(FILE))
        seams = document.getObject("WpCalSeams")
        self.assertEqual((seams.Seams, seams.PartFrame.Base.z), (SEAMS, 3))
        document.getObject("Box").Length = 20
        document.recompute()
        document.save()

    @unittest.skipUnless(STEP == "with", STEP)
    def test_with_the_workbench_it_is_whole_again(self) -> None:
        from freecad.wpcal_wb.document import kinds

        document = FreeCAD.openDocument(str(FILE))
        self.assertEqual(len(document.Objects), 4)
        for kind in kinds.Kind:
            self.assertIsInstance(kinds.object_of(document, kind).Proxy, kinds.Record)
        seams = kinds.object_of(document, kinds.Kind.SEAMS)
        self.assertEqual(kinds.data_of(seams, "Seams"), {"seams": [{"name": "W1 „außen“"}]})
        self.assertEqual([obj.Name for obj in seams.Objects], ["Box"])
        self.assertIn("Hidden", seams.getEditorMode("Seams"))

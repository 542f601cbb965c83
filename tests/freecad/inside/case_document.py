"""Run by `freecadcmd -t`: objects in a document, Undo, and the part as a STEP file."""

import unittest

import FreeCAD
from freecad.wpcal_wb.document import export, kinds
from freecad.wpcal_wb.document.kinds import Kind
from freecad.wpcal_wb.document.session import session_of


class DocumentTest(unittest.TestCase):
    def setUp(self) -> None:
        self.document = FreeCAD.newDocument()
        self.document.UndoMode = 1
        self.addCleanup(FreeCAD.closeDocument, self.document.Name)

    def box(self, label: str = "box", x_mm: float = 0):
        box = self.document.addObject("Part::Box", "Box")
        box.Label = label
        box.Placement.Base.x = x_mm
        self.document.recompute()
        return box


class ObjectsTest(DocumentTest):
    def test_undo_takes_an_object_and_a_change_back(self) -> None:
        with kinds.transaction(self.document, "make"):
            obj = kinds.make_object(self.document, Kind.TAUGHT)
            kinds.set_data(obj, "Table", {"rows": [["Ä1", "1"]]})
        with kinds.transaction(self.document, "change"):
            kinds.set_data(obj, "Table", {"rows": []})
        self.document.undo()
        self.assertEqual(kinds.data_of(obj, "Table"), {"rows": [["Ä1", "1"]]})
        self.document.redo()
        self.assertEqual(kinds.data_of(obj, "Table"), {"rows": []})
        self.document.undo()
        self.document.undo()
        self.assertIsNone(kinds.object_of(self.document, Kind.TAUGHT))

    def test_a_failure_inside_a_transaction_changes_nothing(self) -> None:
        with self.assertRaises(ValueError), kinds.transaction(self.document, "make"):
            kinds.make_object(self.document, Kind.SEAMS)
            raise ValueError("stop")
        self.assertEqual(self.document.Objects, [])

    def test_writing_the_same_data_needs_no_undo(self) -> None:
        obj = kinds.make_object(self.document, Kind.SEAMS)
        kinds.set_data(obj, "Seams", [1])
        obj.purgeTouched()
        kinds.set_data(obj, "Seams", [1])
        self.assertNotIn("Touched", obj.State)

    def test_damaged_data_count_as_none(self) -> None:
        obj = kinds.make_object(self.document, Kind.SEAMS)
        obj.Seams = "{"
        self.assertIsNone(kinds.data_of(obj, "Seams"))


class ExportTest(DocumentTest):
    def names(self, *chosen):
        return [obj.Label for obj in export.part_objects(self.document, chosen)]

    def test_the_visible_solids_that_are_not_part_of_another(self) -> None:
        kinds.make_object(self.document, Kind.SEAMS)
        self.box("hidden").Visibility = False
        cut = self.document.addObject("Part::Cut", "Cut")
        cut.Base, cut.Tool = self.box("a"), self.box("b", 5)
        group = self.document.addObject("App::DocumentObjectGroup", "Group")
        group.addObject(self.box("in a group", 30))
        part = self.document.addObject("App::Part", "Part")
        part.addObject(self.box("in a part", 60))
        self.document.addObject("Sketcher::SketchObject", "Sketch")
        self.document.recompute()
        self.assertEqual(sorted(self.names()), ["Cut", "Part", "in a group"])

    def test_what_was_selected_also_if_it_is_hidden(self) -> None:
        box = self.box("chosen")
        box.Visibility = False
        self.box("other")
        self.assertEqual(self.names(box), ["chosen"])

    def test_the_seams_object_does_not_make_its_part_a_child(self) -> None:
        box = self.box("chosen")
        kinds.make_object(self.document, Kind.SEAMS).Objects = [box]
        self.assertEqual(self.names(), ["chosen"])

    def test_no_solid(self) -> None:
        self.document.addObject("Sketcher::SketchObject", "Sketch")
        with self.assertRaisesRegex(export.NothingToExportError, "no solid"):
            self.names()

    def test_a_part_is_written_once_per_change(self) -> None:
        box = self.box("base plate")
        session = session_of(self.document)
        first = session.write_part()
        self.assertIs(session.write_part(), first)
        self.document.recompute()
        self.assertIs(session.write_part(), first)
        box.Length = 20
        self.document.recompute()
        second = session.write_part()
        self.assertNotEqual((second.path, second.hash), (first.path, first.hash))
        self.assertIn(b"base plate", second.path.read_bytes())
        box.Length = 10
        self.document.recompute()
        self.assertEqual(session.write_part().hash, first.hash)

    def test_what_the_user_does_elsewhere_is_no_change(self) -> None:
        self.box()
        session = session_of(self.document)
        first = session.write_part()
        with kinds.transaction(self.document, "make"):
            kinds.set_data(kinds.make_object(self.document, Kind.SEAMS), "Seams", [1])
        other = FreeCAD.newDocument()
        other.addObject("Part::Box", "Box")
        FreeCAD.closeDocument(other.Name)
        self.assertIs(session.write_part(), first)

    def test_a_part_inside_a_container_comes_in_its_coordinates(self) -> None:
        part = self.document.addObject("App::Part", "Part")
        box = self.box(x_mm=3)
        part.addObject(box)
        part.Placement.Base.y = 100
        self.document.recompute()
        self.assertEqual(tuple(export.frame_of([box]).Base), (0, 100, 0))
        self.assertEqual(tuple(export.frame_of([part]).Base), (0, 0, 0))
        with self.assertRaisesRegex(export.NothingToExportError, "different places"):
            export.frame_of([box, part])

    def test_the_model_is_not_changed(self) -> None:
        box = self.box("mine")
        before = [(obj.Name, obj.Label, str(obj.Placement), obj.State) for obj in self.document.Objects]
        steps = self.document.UndoCount
        session_of(self.document).write_part()
        after = [(obj.Name, obj.Label, str(obj.Placement), obj.State) for obj in self.document.Objects]
        self.assertEqual((after, self.document.UndoCount), (before, steps))
        self.assertTrue(box.Visibility)

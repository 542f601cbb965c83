"""Run by `freecadcmd -t`: the whole job on the tee with wpcal itself, without a window."""

import json
import os
import signal
import sys
import unittest
from pathlib import Path

import FreeCAD
import Part
from freecad.wpcal_wb.document import kinds, picks
from freecad.wpcal_wb.document.calibration import fit_params, keep_fit, pose_of
from freecad.wpcal_wb.document.kinds import Kind
from freecad.wpcal_wb.document.pasted import pasted_points
from freecad.wpcal_wb.document.placed import placed_part
from freecad.wpcal_wb.document.seams import SeamModel
from freecad.wpcal_wb.document.session import session_of, stop_sessions
from freecad.wpcal_wb.document.shown import Shown
from freecad.wpcal_wb.document.taught import TaughtModel

TEE = Path(os.environ["WPCAL_TEST_ROOT"]) / "fixtures/tee"
SAVED = Path(os.environ["WPCAL_TEST_FOLDER"]) / "tee.FCStd"
ROUND_OFF_MM = 1e-6  #: The part went through FreeCAD's STEP files, which have about 13 digits.


def tee():
    """Return a document with the tee."""
    document = FreeCAD.newDocument("tee")
    document.UndoMode = 1
    Part.insert(str(TEE / "tee.step"), document.Name)  # Import.insert crashes on this file without a window
    document.recompute()
    return document


def find_seams(model, text="Find"):
    return model.session.ask("seams", model.request(), on_result=lambda found: model.take_seams(found, text)).wait()


class JobTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.document = tee()
        cls.session = session_of(cls.document)
        cls.model = SeamModel(cls.session)
        cls.users_model = cls.state_of_the_model()
        cls.model.take_features(cls.session.open().wait())
        cls.find()

    @classmethod
    def tearDownClass(cls) -> None:
        stop_sessions()

    @classmethod
    def find(cls, text="Find seams"):
        return find_seams(cls.model, text)

    @classmethod
    def state_of_the_model(cls):
        objects = [obj for obj in cls.document.Objects if not kinds.is_ours(obj)]
        return [(obj.Name, obj.Label, str(getattr(obj, "Placement", "")), obj.Visibility, obj.State) for obj in objects]

    def seam(self, name):
        return next(seam for seam in self.model.seams if seam["name"] == name)

    def test_features_and_seams_are_kept_and_the_model_is_not_changed(self) -> None:
        self.assertIn("V2", {one["name"] for one in self.model.features})
        self.assertEqual([seam["name"] for seam in self.model.seams if seam["accepted"]], ["W2", "W3"])
        self.assertFalse(self.model.is_stale)
        self.assertEqual(self.state_of_the_model(), self.users_model)

    def test_a_decision_and_its_answer_are_one_step_of_undo(self) -> None:
        start = self.seam("W2")["frames"]["p"][0]
        self.model.reverse(self.seam("W2"))
        self.model.weld(self.seam("W1"), True)
        self.find("Decide")
        self.assertTrue(self.seam("W1")["accepted"])
        self.assertEqual(self.seam("W2")["frames"]["p"][-1], start)
        self.document.undo()
        self.assertFalse(self.seam("W1")["accepted"])
        self.assertEqual((self.seam("W2")["frames"]["p"][0], self.model.decisions), (start, []))

    def test_a_decision_that_wpcal_refuses_changes_nothing(self) -> None:
        before = (self.model.seams, self.model.decisions)
        self.model.decide(self.seam("W2"), name="\n")
        with self.assertRaisesRegex(RuntimeError, "name"):
            self.find()
        self.model.forget_pending()
        self.assertEqual((self.model.seams, self.model.decisions), before)

    def test_an_edge_with_a_candidate_and_one_without(self) -> None:
        on_seam = picks.edge_points(self.edge((25, 56, 10), (175, 56, 10)), None, FreeCAD.Placement())
        self.assertEqual(self.model.seam_on_edge(on_seam)["name"], "W2")
        free = picks.edge_points(self.edge((0, 0, 0), (0, 0, 10)), None, FreeCAD.Placement())
        self.assertIsNone(self.model.seam_on_edge(free))
        self.model.add_edge(free[0])
        self.find("Add an edge")
        middles = [seam["candidate"]["middle_part_mm"] for seam in self.model.seams if seam["accepted"]]
        self.assertIn([0, 0, 5], middles)
        self.assertIn([100, 56, 10], middles)
        self.document.undo()
        self.assertEqual(self.model.options, {})

    def edge(self, *ends):
        shapes = [obj.Shape for obj in self.document.Objects if obj.isDerivedFrom("Part::Feature")]
        for one in (edge for shape in shapes for edge in shape.Edges):
            if {tuple(round(x, 6) for x in vertex.Point) for vertex in one.Vertexes} == set(ends):
                return one
        raise AssertionError(f"no edge between {ends}")

    def test_taught_points_of_a_file_give_the_answer_of_the_command(self) -> None:
        taught = TaughtModel(self.session)
        read = self.session.ask("read_taught", {"path": str(TEE / "taught.csv")}).wait()
        taught.write(read["columns"], read["rows"], "Read")
        fit = self.session.ask("calibrate", fit_params(self.document)).wait()
        golden = json.loads((TEE / "golden/calibration.json").read_text())
        ours, of_command = ([x for row in record["T_base_part"] for x in row] for record in (fit, golden))
        self.assertEqual(len(ours), len(of_command))
        for number, value in enumerate(ours):
            self.assertAlmostEqual(value, of_command[number], delta=ROUND_OFF_MM)
        self.assertEqual(fit["record"]["verdict"], golden["verdict"])

    def test_plates_that_moved_are_shown_where_they_are(self) -> None:
        taught = TaughtModel(self.session)
        read = self.session.ask("read_taught", {"path": str(TEE / "taught.csv")}).wait()
        taught.write(read["columns"], read["rows"], "Read")
        fit = self.session.ask("calibrate", fit_params(self.document, {"bodies": True})).wait()
        with kinds.transaction(self.document, "Place"):
            keep_fit(self.session, fit, Shown(at_pose=True))
        self.document.recompute()
        T_base_part, seen = pose_of(fit["T_base_part"]), 0
        found = [vertex.Point for vertex in Part.getShape(placed_part(self.document)).Vertexes]
        for body in fit["record"]["bodies"]["bodies"]:
            T_base_moved = T_base_part.multiply(pose_of(body["T_part_moved"]))
            for feature in self.session.opened["features"]:
                if feature["kind"] == "vertex" and [feature["solid"]] == body["solids"]:
                    place = T_base_moved.multVec(FreeCAD.Vector(*feature["p_mm"]))
                    self.assertLess(min(place.distanceToPoint(each) for each in found), ROUND_OFF_MM)
                    seen += 1
        self.assertGreater(len(fit["record"]["bodies"]["bodies"]), 1)
        self.assertEqual(seen, sum(one["kind"] == "vertex" for one in self.session.opened["features"]))
        self.document.undo()

    def test_clicks_become_rows_that_wpcal_reads(self) -> None:
        taught = TaughtModel(self.session)
        taught.write(taught.columns, [], "Empty")
        self.assertEqual(taught.feature_at((0, 0, 10)), "V2")
        row = taught.add_feature("V2")
        self.assertEqual(taught.add_feature("V2"), row)
        touch = self.session.ask("touch_at", {"p_mm": [100, 20, 10], "normal": [0, 0, 1]}).wait()
        taught.add_place(touch["p_mm"], touch["kind"])
        taught.add_place((100, 0, 10), "edge")
        taught.put_points(
            0, pasted_points("812,29;-240,62;165,80\nX 850.1 Y -200 Z 160\nP3 [[870,-220.5,164],[1,0,0,0]]")
        )
        with self.assertRaisesRegex(ValueError, "line 2.*thousands"):
            pasted_points("812 240 165.5\n1 234,5 2 000,0 3,0")
        with self.assertRaisesRegex(ValueError, "line 1: expected three numbers"):
            pasted_points("P1 812.3 P2")
        records = taught.records()
        self.assertEqual([one["name"] for one in records], ["V2", "T1", "T2"])
        self.assertEqual([one["x_mm"] for one in records], ["812.29", "850.1", "870"])
        self.assertEqual(records[1]["kind"], "plane")
        taught.next_use([0])
        self.assertEqual(taught.cell(0, "use"), "check")
        taught.remove([1, 2])
        answer = self.session.ask("suggest", {"taught": taught.request()}).wait()
        self.assertTrue(set(answer["features"]) <= set(taught.features))

    def test_wpcal_may_crash_and_the_next_question_has_an_answer(self) -> None:
        os.kill(self.session.client.process_id, signal.SIGKILL)
        with self.assertRaisesRegex(RuntimeError, "stopped"):
            self.session.client.call("formats").wait()
        self.assertEqual(len(self.find()["seams"]), len(self.model.seams))

    def test_a_part_that_was_changed_is_opened_anew(self) -> None:
        other = FreeCAD.newDocument()
        self.addCleanup(FreeCAD.closeDocument, other.Name)
        plate, rib = (other.addObject("Part::Box", name) for name in ("Plate", "Rib"))
        plate.Length = plate.Width = 100
        rib.Length, rib.Width, rib.Height = 50, 5, 30
        rib.Placement.Base = FreeCAD.Vector(20, 40, 10)
        other.recompute()
        model = SeamModel(session_of(other))
        find_seams(model)
        self.assertEqual(max(seam["length_mm"] for seam in model.seams), 50)
        longest = max(model.seams, key=lambda seam: seam["length_mm"])
        shortest = min(model.seams, key=lambda seam: seam["length_mm"])
        model.reverse(longest)
        model.weld(shortest, True)
        rib.Length = 60
        other.recompute()
        self.assertTrue(model.is_stale)
        found = model.session.ask("seams", {"options": model.options}).wait()
        self.assertEqual(
            model.drop_unfitting(found["seams"]), [longest["name"]], "one end of the rib stayed where it was"
        )
        find_seams(model)
        self.assertEqual([one["candidate"]["name"] for one in model.decisions], [shortest["name"]])
        self.assertEqual(max(seam["length_mm"] for seam in model.seams), 60)
        self.assertFalse(model.is_stale)
        container = other.addObject("App::Part", "Part")
        model.use_objects([plate, rib])
        for obj in (plate, rib):
            container.addObject(obj)
        self.assertFalse(model.is_stale)
        container.Placement.Base.x = 10
        self.assertTrue(model.is_stale, "the same part at another place")

    def test_saved_and_opened_again_nothing_is_lost_and_nothing_is_stale(self) -> None:
        self.document.saveAs(str(SAVED))
        copy = FreeCAD.openDocument(str(SAVED.rename(SAVED.with_name("copy.FCStd"))))
        self.addCleanup(FreeCAD.closeDocument, copy.Name)
        model = SeamModel(session_of(copy))
        self.assertEqual((model.seams, model.features), (self.model.seams, self.model.features))
        self.assertIsInstance(kinds.object_of(copy, Kind.SEAMS).Proxy, kinds.Record)
        self.assertFalse(model.is_stale)

    def test_no_other_cad_kernel_came_into_freecads_process(self) -> None:
        names = {name.split(".")[0] for name in sys.modules}
        self.assertFalse(names & {"OCP", "build123d", "wpcal", "cad", "cadquery", "ezdxf", "trimesh"})

"""The part at its pose: links that lie where the robot found the part, whatever containers the objects are in."""

import unittest

import FreeCAD
import Part
from freecad.wpcal_wb.document.export import frame_of, part_objects
from freecad.wpcal_wb.document.kinds import transaction
from freecad.wpcal_wb.document.moved_solids import moved_solids
from freecad.wpcal_wb.document.placed import MOST_FRAMES, NamedFrame, add_frames, place_part, placed_part, remove_placed

NEAR_MM = 1e-4  #: Corners are compared with five decimals.
POSE = FreeCAD.Placement(FreeCAD.Vector(812, -240, 155), FreeCAD.Rotation(FreeCAD.Vector(0.1, -0.2, 1), 31))


class PlacedPart(unittest.TestCase):
    def setUp(self):
        self.document = FreeCAD.newDocument("placed")
        self.document.UndoMode = 1

    def tearDown(self):
        FreeCAD.closeDocument(self.document.Name)

    def box(self, name, place, container=None):
        box = self.document.addObject("Part::Box", name)
        box.Placement = FreeCAD.Placement(FreeCAD.Vector(*place), FreeCAD.Rotation(FreeCAD.Vector(0, 1, 0), 17))
        if container is not None:
            container.addObject(box)
        return box

    def container(self, name, place):
        container = self.document.addObject("App::Part", name)
        container.Placement = FreeCAD.Placement(FreeCAD.Vector(*place), FreeCAD.Rotation(FreeCAD.Vector(1, 0, 0), 40))
        return container

    def place(self, objects):
        self.document.recompute()
        with transaction(self.document, "Place"):
            return place_part(self.document, objects, POSE)

    def corners(self, shape):
        return sorted(tuple(round(value, 5) for value in vertex.Point) for vertex in shape.Vertexes)

    def check(self, objects):
        """Compare every corner with the pose of the part in its own coordinates."""
        part = self.place(objects)
        self.document.recompute()
        inverse = frame_of(objects).inverse()
        expected = []
        for obj in objects:
            shape = obj.Shape.copy()
            container = obj.getParentGeoFeatureGroup()
            world = container.Placement if container is not None else FreeCAD.Placement()
            shape.Placement = POSE.multiply(inverse).multiply(world).multiply(obj.Placement)
            expected += self.corners(shape)
        found = Part.getShape(part)
        for one, other in zip(self.corners(found), sorted(expected), strict=True):
            self.assertLess(FreeCAD.Vector(*one).distanceToPoint(FreeCAD.Vector(*other)), NEAR_MM)
        return part

    def test_objects_with_a_place_of_their_own(self):
        self.check([self.box("A", (5, 6, 7)), self.box("B", (-20, 0, 3))])

    def test_objects_in_a_container_with_a_place(self):
        container = self.container("Holder", (100, 200, 300))
        self.check([self.box("A", (5, 6, 7), container), self.box("B", (-20, 0, 3), container)])

    def test_the_placed_part_is_no_part_of_the_model(self):
        boxes = [self.box("A", (5, 6, 7)), self.box("B", (-20, 0, 3))]
        self.place(boxes)
        self.assertEqual(part_objects(self.document), boxes)

    def test_placing_again_keeps_one_link_per_object_and_the_pose_is_new(self):
        boxes = [self.box("A", (5, 6, 7)), self.box("B", (-20, 0, 3))]
        first = self.place(boxes)
        again = self.place(boxes[:1])
        self.assertEqual(again, first)
        self.assertEqual([obj.LinkedObject for obj in again.Group if obj.TypeId == "App::Link"], boxes[:1])

    def features(self, **solids):
        """Return features as wpcal names them, of solids by their names."""
        return [
            {"kind": "vertex", "solid": name, "p_mm": list(vertex.Point)}
            for name, solid in solids.items()
            for vertex in solid.Vertexes
        ]

    def body(self, name, move):
        A = move.toMatrix().A
        return {"solids": [name], "T_part_moved": [list(A[row : row + 4]) for row in (0, 4, 8, 12)]}

    def test_each_object_is_where_its_solids_moved(self):
        """Two boxes that touch, and one object of two solids: all moved differently."""
        boxes = [self.box("A", (5, 6, 7)), self.box("B", (15, 6, 7))]
        both = self.document.addObject("Part::Feature", "Both")
        both.Shape = Part.makeCompound([Part.makeBox(3, 4, 5), Part.makeBox(3, 4, 5, FreeCAD.Vector(3, 0, 0))])
        self.document.recompute()
        objects = [*boxes, both]
        solids = [boxes[0].Shape, boxes[1].Shape, *both.Shape.Solids]
        moves = [
            FreeCAD.Placement(FreeCAD.Vector(k, 1, 0.5), FreeCAD.Rotation(FreeCAD.Vector(0, 1, 1), k)) for k in range(4)
        ]
        names = ["A", "B", "Both", "Both#2"]
        features = self.features(**dict(zip(names[::-1], solids[::-1], strict=True)))
        bodies = [self.body(name, move) for name, move in zip(names, moves, strict=True)]
        moved = moved_solids(objects, features, bodies)
        with transaction(self.document, "Place"):
            part = place_part(self.document, objects, POSE, moved)
        self.document.recompute()
        expected = []
        for solid, move in zip(solids, moves, strict=True):
            shape = solid.copy()
            shape.Placement = POSE.multiply(move).multiply(shape.Placement)
            expected += self.corners(shape)
        for one, other in zip(self.corners(Part.getShape(part)), sorted(expected), strict=True):
            self.assertLess(FreeCAD.Vector(*one).distanceToPoint(FreeCAD.Vector(*other)), NEAR_MM)
        self.assertEqual(part_objects(self.document), objects)
        self.check(objects)  # fitted as one piece again: nothing of the motions is left
        self.assertEqual([obj.TypeId for obj in part.Group], ["App::Link"] * 3)
        self.assertIsNone(moved_solids(objects, features, bodies[:-1])["Both"])

    def test_removing_it_leaves_the_model(self):
        boxes = [self.box("A", (5, 6, 7))]
        part = self.place(boxes)
        with transaction(self.document, "Frames"):
            add_frames(self.document, part, [NamedFrame("W1_1", FreeCAD.Placement())])
        with transaction(self.document, "Remove"):
            remove_placed(self.document)
        self.assertIsNone(placed_part(self.document))
        self.assertEqual([obj.Name for obj in self.document.Objects if obj.TypeId.startswith("Part")], ["A"])

    def test_too_many_coordinate_systems_are_refused(self):
        part = self.place([self.box("A", (0, 0, 0))])
        frames = [NamedFrame("W1", FreeCAD.Placement())] * (MOST_FRAMES + 1)
        with self.assertRaises(ValueError):
            add_frames(self.document, part, frames)

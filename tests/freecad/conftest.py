"""What runs inside FreeCAD is no module of these tests."""

collect_ignore = ["inside"]

"""A plan of touches for the tee, written by hand: `fixtures/tee/touches_plan`.

`python -m tests.touch_plans` writes it again, and `fixtures/tee/two_touches`.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches import Contact, Search, TouchPlan, touches_csv, touches_record
from wpcal.touch.searches.record import TOUCHES_FILE

TEE_PLAN = Path(__file__).parents[1] / "fixtures" / "tee" / "touches_plan"
TWO_TOUCHES = TEE_PLAN.with_name("two_touches")  #: T1 and T4 of it: short enough for the programs in the docs.
CLEAR_Z_MM = 115.0  #: 25 mm above the web.
DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
"""The torch points down; its x is that of the part."""
STROKE_MM, START_MM = 16.0, 8.0
WIRE_MM, STICK_OUT_MM = 1.2, 15.0
TOUCHED = (
    # name, target, feature, contact, normal, what meets the face
    ("T1", "plane", "", (40.0, 100.0, 10.0), (0.0, 0.0, 1.0), Contact.END),
    ("T2", "plane", "", (160.0, 100.0, 10.0), (0.0, 0.0, 1.0), Contact.END),
    ("T3", "plane", "", (100.0, 20.0, 10.0), (0.0, 0.0, 1.0), Contact.END),
    ("T4", "plane", "", (40.0, 0.0, 5.0), (0.0, -1.0, 0.0), Contact.SIDE),
    ("T5", "plane", "", (160.0, 0.0, 5.0), (0.0, -1.0, 0.0), Contact.SIDE),
    ("T6", "plane", "", (0.0, 60.0, 5.0), (-1.0, 0.0, 0.0), Contact.SIDE),
    ("T7", "plane", "", (175.0, 60.0, 50.0), (1.0, 0.0, 0.0), Contact.SIDE),
    ("T8", "hole", "H1", (20.0, 25.0, 5.0), (0.0, -1.0, 0.0), Contact.SIDE),
)
"""T8 is inside a hole of 10 mm: its stroke is shorter."""


def tee_plan() -> TouchPlan:
    """Return eight searches on the tee, which stands as in `fixtures/tee/truth.json` but for a millimetre."""
    place = RigidTransform.from_six_tuple([812.0, -240.0, 156.0, 0.02, -0.035, 0.6], target="base", source="part")
    return TouchPlan("tee.step", tuple(_search(*each) for each in TOUCHED), place, WIRE_MM, STICK_OUT_MM)


def two_touches() -> TouchPlan:
    """Return a search with the end of the wire, and one with its side."""
    plan = tee_plan()
    return replace(plan, searches=(plan.search("T1"), plan.search("T4")))


def _search(
    name: str, target: str, feature: str, at: tuple[float, ...], towards: tuple[float, ...], contact: Contact
) -> Search:
    p, normal = np.array(at), np.array(towards)
    radius = WIRE_MM / 2 if contact is Contact.SIDE else 0.0
    before, after = (START_MM, STROKE_MM - START_MM) if target == "plane" else (3.0, 3.0)
    start, end = p + (radius + before) * normal, p + (radius - after) * normal
    above = np.array([start[0], start[1], CLEAR_Z_MM])
    none = np.empty((0, 3))
    return Search(
        name, target, feature, p, normal, contact, radius, DOWN, none, above, start, end, above, _covariance(normal)
    )


def _covariance(normal: FloatArray) -> FloatArray:
    """0.1 mm per axis, 0.5 mm of stick-out, 1 ms at 10 mm/s."""
    wire = DOWN[:, 2]
    return 0.01 * np.eye(3) + 0.25 * np.outer(wire, wire) + 1e-4 * np.outer(normal, normal)


if __name__ == "__main__":
    TEE_PLAN.mkdir(exist_ok=True)
    (TEE_PLAN / TOUCHES_FILE).write_text(to_json(touches_record(tee_plan())), encoding="utf-8")
    TWO_TOUCHES.mkdir(exist_ok=True)
    (TWO_TOUCHES / TOUCHES_FILE).write_text(to_json(touches_record(two_touches())), encoding="utf-8")
    (TEE_PLAN / "touches.csv").write_text(touches_csv(tee_plan()), encoding="utf-8")

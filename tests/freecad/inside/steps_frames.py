"""Draw 10 000 seam frames as one object, turn the view, and count the pictures that are really drawn per second."""

import math
import time

import FreeCAD
import FreeCADGui
from pivy import coin

FRAMES = 10_000
PICTURES = 60


def fit_with_frames(count):
    """Return an answer of `calibrate` with one long seam on a helix."""
    places, axes = [], []
    for number in range(count):
        angle = 0.02 * number
        c, s = math.cos(angle), math.sin(angle)
        places.append([500 * c, 500 * s, 0.1 * number])
        axes.append([[-s, 0, c], [c, 0, s], [0, 1, 0]])
    frames = {"p": places, "R": axes, "u95": [0.3] * count}
    seams = [{"name": "W1", "accepted": True, "frames": frames}]
    identity = [[float(row == column) for column in range(4)] for row in range(4)]
    record = {"verdict": "PASS", "tolerance_mm": 0.5}
    return {"record": record, "T_base_part": identity, "points": [], "seams": seams}


def steps(window):
    from freecad.wpcal_wb.document.kinds import Kind, make_object, set_data, transaction
    from freecad.wpcal_wb.document.shown import Shown

    window.say("draw the frames")
    document = FreeCAD.newDocument("frames")
    start = time.perf_counter()
    with transaction(document, "frames"):
        obj = make_object(document, Kind.CALIBRATION)
        set_data(obj, "Shown", Shown(frames=True, on_model=False)._asdict())
        set_data(obj, "Calibration", fit_with_frames(FRAMES))
    window.facts["objects"] = len(document.Objects)
    window.facts["made_s"] = time.perf_counter() - start
    view = window.view()
    view.viewIsometric()
    view.fitAll()
    yield 0.5
    drawn = []
    counter = coin.SoCallback()
    counter.setCallback(lambda _data, action: drawn.append(action.isOfType(coin.SoGLRenderAction.getClassTypeId())))
    view.getSceneGraph().addChild(counter)
    window.say("turn the view")
    start = time.perf_counter()
    for number in range(PICTURES):
        turned = FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), 6.0 * number)
        view.setCameraOrientation(turned.multiply(FreeCAD.Rotation(FreeCAD.Vector(1, 0, 0), 55)).Q)
        FreeCADGui.updateGui()
    seconds = time.perf_counter() - start
    window.facts["pictures_drawn"] = sum(drawn)
    window.facts["pictures_per_s"] = sum(drawn) / seconds
    window.facts["canvas_px"] = [window.canvas().width(), window.canvas().height()]
    yield from window.shot("frames")

"""`cad.show`: what it draws, and the message that reaches the viewer, without a screen."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cad
from cad.draw.page_colours import AXES, BEYOND, PART, RESIDUAL, STOPS, UNKNOWN, colour_of
from cad.workpiece.calibrate import WorkpieceCalibration
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.show import ARROW_SCALE, drawn_of
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.taught.features import FeatureKind
from wpcal.taught.table import TaughtPoints

PAGES = Path(__file__).parents[2] / "wpcal" / "pages" / "source" / "src"
T_BASE_PART = RigidTransform.from_six_tuple([900.0, -100.0, 50.0, 0.1, -0.2, 0.3], target="base", source="part")
OFF_MM = np.array([[0.1, 0, 0], [0, 0.1, 0], [0, 0, -0.1], [-0.1, 0, 0], [0, -0.1, 0.1]])


@pytest.fixture(scope="module")
def found() -> WorkpieceCalibration:
    """A tee that was touched at five corners."""
    from build123d import Box, Pos

    plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
    plate.label, web.label = "plate", "web"
    part = cad.open_workpiece([plate, web])
    corners = [feature for feature in part.features if feature.kind is FeatureKind.VERTEX][:5]
    p_base = T_BASE_PART.apply(np.array([corner.p_mm for corner in corners])) + OFF_MM
    touched = TaughtPoints.of_features([corner.name for corner in corners], p_base)
    return cad.calibrate_workpiece(part, touched, options=CalibrateOptions(tolerance_mm=2.0))


def test_the_colours_are_those_of_the_pages() -> None:
    scale, viewer = (PAGES / "colours.js").read_text(), (PAGES / "viewer.js").read_text()
    stops = re.findall(r"\[(\d\.\d), \[(\d+), (\d+), (\d+)\]\]", scale)
    assert [(float(stop), tuple(map(int, rgb))) for stop, *rgb in stops] == list(STOPS)
    assert f'BEYOND = "{BEYOND}"' in scale
    assert f'return "{UNKNOWN}"' in scale
    assert ", ".join(f'"{axis}"' for axis in AXES) in viewer
    assert f'part: "{PART}"' in viewer
    assert f'RESIDUAL = "{RESIDUAL}"' in (PAGES / "residuals.js").read_text()
    assert [colour_of(share) for share in (0.0, 1.0, 1.1, np.nan)] == ["#117a8b", "#be1e2d", BEYOND, UNKNOWN]
    assert colour_of(0.15) == "#289183"


def test_seams_frames_points_and_residuals_are_where_they_are_in_the_base(found: WorkpieceCalibration) -> None:
    drawn = {each.name: each for each in drawn_of(found)}
    assert {"plate", "web", "frames x", "frames y", "frames z", "taught points"} <= set(drawn)
    for seam, u95 in zip(found.candidates, found.candidate_u95_mm, strict=True):
        begin = found.T_base_part.apply(seam.frames.p[:1])[0]
        assert np.linalg.norm(np.array(tuple(drawn[seam.name].shape @ 0)) - begin) < 1e-6
        expected = colour_of(u95.max() / found.result.tolerance_mm) if seam.accepted else UNKNOWN
        assert drawn[seam.name].color == expected
    frames = sum(len(seam.frames) for seam in found.candidates)
    assert len(drawn["frames x"].shape.edges()) == frames
    seen = sorted(tuple(point) for point in drawn["taught points"].shape.vertices())
    assert np.allclose(seen, sorted(map(tuple, found.result.pairs.p_target)))
    long = sum(edge.length for edge in drawn[f"residuals x {ARROW_SCALE:g}"].shape.edges())
    assert long == pytest.approx(ARROW_SCALE * found.result.residuals.norms_mm.sum())


def test_what_the_viewer_is_given(found: WorkpieceCalibration, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[Any] = []
    camera = SimpleNamespace(RESET="reset")
    fake = SimpleNamespace(Camera=camera, show=lambda *shapes, **named: given.append((shapes, named)))
    monkeypatch.setitem(sys.modules, "ocp_vscode", fake)
    cad.show(found.workpiece, found.seams, port=3940)
    [(shapes, named)] = given
    assert len(shapes) == len(named["names"]) == len(named["colors"]) == len(named["alphas"])
    assert named["port"] == 3940
    fake.find_and_set_port, fake.get_port = lambda: None, lambda: None
    with pytest.raises(InputError, match="no open viewer"):
        cad.show(found)
    monkeypatch.setitem(sys.modules, "ocp_vscode", None)
    with pytest.raises(InputError, match=r"pip install wpcal\[viewer\]"):
        cad.show(found)


def test_the_message_of_the_viewer_has_every_object(
    found: WorkpieceCalibration, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OCP_VIEWER_PYTEST", "1")
    ocp_vscode = pytest.importorskip("ocp_vscode", reason="ocp_vscode is not installed")
    answers: list[Any] = []
    real = ocp_vscode.show
    monkeypatch.setattr(ocp_vscode, "show", lambda *shapes, **named: answers.append(real(*shapes, **named)))
    cad.show(found, port=3939)
    told = dict(_told(answers[0][0]))
    for each in drawn_of(found):
        assert told[each.name] == each.color, each.name


def _told(value: Any) -> Iterator[tuple[str, str]]:
    """Yield name and colour of every object in a message."""
    if isinstance(value, dict):
        colour = value.get("color")
        if "name" in value and colour:
            yield value["name"], colour["face"] if isinstance(colour, dict) else colour
        yield from (found for inner in value.values() for found in _told(inner))
    elif isinstance(value, list | tuple):
        yield from (found for inner in value for found in _told(inner))

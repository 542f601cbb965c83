"""The report in a browser: it needs no other file, and its view and numbers agree with the result files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.few import few
from tests.running import run_here
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import read_part_glb, write_part_glb
from wpcal.core.arrays import FloatArray
from wpcal.pages.report import build_report
from wpcal.results.folder import read_result_folder

SADDLE = Path(__file__).parents[2] / "fixtures" / "saddle"
HOSTILE = "</script><img src=x onerror=window.hacked=1>"
RESIDUAL_PINK = (214, 36, 110)
NEAR = 40.0  #: Of a colour, 0…255 in three channels: what smoothing and rounding leave of it in the middle of a line.
PHONE_WIDTH = 390
ON_FACES = [
    ("base plate", [150.0, 30.0, 10.0], [0.0, 0.0, 1.0]),
    ("web", [100.0, 56.0, 50.0], [0.0, -1.0, 0.0]),
    ("web", [100.0, 60.0, 90.0], [0.0, 0.0, 1.0]),
    ("web", [25.0, 60.0, 50.0], [-1.0, 0.0, 0.0]),
]
"""Solid, place and outward normal in the frame `part`: faces that the first view shows."""
DRAWN_MM, DRAWN_RAD = 0.02, 1e-3
"""A step of the mesh is 0.003 mm; the rest is 32-bit numbers in the browser, and a triangle's normal from them."""
SEAM, FRAME = 1, 7  #: W2 faces the viewer; its eighth frame is away from both ends.
BEHIND = 2  #: W3 is on the far side of the web.

pytestmark = pytest.mark.usefixtures("kernel_here")


def run_wpcal(*arguments: str | Path) -> None:
    done = run_here(*arguments)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def folder(kernel_here: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The result of `wpcal demo`."""
    out = tmp_path_factory.mktemp("demo") / "out"
    run_wpcal("demo", "-o", out)
    return out


@pytest.fixture(scope="module")
def report(folder: Path, open_pages: Any) -> Any:
    """Its page, for tests that change nothing on it."""
    return open_pages(folder / "report.html")


def seams(folder: Path) -> Any:
    return json.loads((folder / "seams.json").read_text(encoding="utf-8"))["seams"]


def count(pixels: FloatArray, colour: tuple[int, int, int]) -> int:
    return int(np.sum(np.linalg.norm(pixels - colour, axis=2) < NEAR))


def test_it_stands_alone(folder: Path, report: Any) -> None:
    assert report.said == []
    assert report.asked == [(folder / "report.html").as_uri()]
    header = report.page.locator("header")
    assert header.locator(".stamp").inner_text() == "PASS"
    record = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))
    worst = max(record["points"], key=lambda point: point["distance_mm"])
    assert f"{worst['distance_mm']:.3f} mm" in header.inner_text()
    assert f"at {worst['name']} " in header.inner_text()
    sources = report.page.locator("#sources").inner_text()
    assert all(entry["sha256"] in sources for entry in record["inputs"].values())
    assert report.page.locator("#points tbody tr").count() == len(record["points"])
    assert report.page.locator("svg.chart").count() == 1


@pytest.mark.parametrize("width", few([PHONE_WIDTH, 1280], 1))
def test_nothing_is_wider_than_the_window(folder: Path, open_page: Any, width: int) -> None:
    found = open_page(folder / "report.html", width=width)
    assert found.page.evaluate("document.documentElement.scrollWidth") == width


def test_the_tooltip_shows_what_seams_json_says(folder: Path, report: Any) -> None:
    seam = seams(folder)[SEAM]
    frame = seam["frames"][FRAME]
    report.page.mouse.move(*report.project(frame["p_mm"]))
    tip = report.page.locator(".tooltip")
    tip.wait_for(state="visible")
    text = tip.inner_text()
    assert text.startswith(seam["name"])
    assert f"{frame['s_mm']:.3f} of {seam['length_mm']:.3f} mm" in text
    assert ", ".join(f"{v:.3f}" for v in frame["p_mm"]) in text
    assert f"{frame['slope_deg']:.1f}° / {frame['rotation_deg']:.1f}° ({frame['position']})" in text
    assert f"{frame['u95_mm']:.4f} mm" in text
    report.page.mouse.move(3, 3)
    tip.wait_for(state="hidden")


def test_the_tooltip_of_a_point_shows_its_residual(folder: Path, report: Any) -> None:
    points = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))["points"]
    (point,) = [one for one in points if one["name"] == "V12"]
    report.page.mouse.move(*report.project(point["p_base_mm"]))
    tip = report.page.locator(".tooltip")
    tip.wait_for(state="visible")
    assert ", ".join(f"{v:+.4f}" for v in point["residual_mm"]) in tip.inner_text()
    assert f"{point['distance_mm']:.4f} mm" in tip.inner_text()


def test_the_next_steps_and_the_notes_stand_under_the_verdict_before_the_view(
    folder: Path, tmp_path: Path, open_page: Any
) -> None:
    files = read_result_folder(folder)
    calibration = files.calibration | {"verdict": "FAIL"}
    calibration["judgement"] |= {"kind": "FAIL", "reason": "contradiction", "sentence": "the others contradict V4"}
    calibration["suspect"] = {"names": ["V4"], "exchanges": []}
    calibration["issues"] = [{"code": "blunder", "message": "the others contradict V4", "ids": ["V4"]}]
    (tmp_path / "report.html").write_text(build_report(calibration, files.seams, files.part_glb), encoding="utf-8")
    found = open_page(tmp_path / "report.html")
    order = found.page.evaluate("[...document.querySelectorAll('#page > *')].map((one) => one.id || one.tagName)")
    assert order[:4] == ["HEADER", "steps", "notes", "view"]
    steps = found.page.locator("#steps").inner_text()
    assert "Touch V4 again" in steps
    assert "docs/how-to/fail-what-now.md" in steps
    bottom = found.page.locator("#steps").bounding_box()
    assert bottom["y"] + bottom["height"] < 900  # on the first screen


def test_the_view_and_the_rows_answer_to_the_keyboard(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    page, place = found.page, seams(folder)[SEAM]["frames"][FRAME]["p_mm"]

    def drawn() -> Any:
        page.evaluate("() => window.wpcal.viewer.draw()")  # at once, not before the next frame
        spot = page.evaluate("p => window.wpcal.project(p)", place)
        return np.array([spot["x"], spot["y"]])

    page.locator(".stage canvas").focus()
    first = drawn()
    page.keyboard.press("ArrowRight")
    turned = drawn()
    assert np.linalg.norm(turned - first) > 2.0
    page.keyboard.press("ArrowLeft")
    np.testing.assert_allclose(drawn(), first, rtol=0, atol=0.5)
    page.keyboard.press("+")
    page.keyboard.press("Shift+ArrowUp")
    assert np.linalg.norm(drawn() - first) > 5.0
    page.keyboard.press("Home")
    np.testing.assert_allclose(drawn(), first, rtol=0, atol=0.5)
    for row in (page.locator("#seams tbody tr", has_text="W3").first, page.locator("#points tbody tr").first):
        before = drawn()
        row.focus()
        page.keyboard.press("Enter")
        assert np.linalg.norm(drawn() - before) > 5.0
    assert page.evaluate("document.activeElement.tagName") == "TR"


@pytest.mark.deep
def test_a_phone_shows_the_95_percent_column_and_the_table_has_the_taught_coordinates(
    folder: Path, open_page: Any
) -> None:
    found = open_page(folder / "report.html", width=PHONE_WIDTH)
    for section in ("#points", "#seams"):
        box = found.page.locator(f"{section} th", has_text="95 % error mm").first.bounding_box()
        assert box["x"] + box["width"] <= PHONE_WIDTH
    point = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))["points"][0]
    cells = found.page.locator("#points tbody tr").first.locator("td").all_inner_texts()
    assert cells[5:8] == [f"{v:.3f}" for v in point["p_base_mm"]]


@pytest.mark.deep
def test_a_distance_is_measured_and_the_part_is_cut_open(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    page = found.page
    T = np.array(json.loads((folder / "calibration.json").read_text(encoding="utf-8"))["T_base_part"])
    page.get_by_label("measure").check()
    said = page.locator("output[data-test='measured']")
    corners = [[0.0, 0.0, 10.0], [200.0, 0.0, 10.0]]
    for corner in corners:
        page.mouse.click(*found.project((T @ [*corner, 1.0])[:3].tolist()))
    assert said.inner_text().startswith("200.000 mm")
    page.get_by_label("measure").uncheck()
    assert said.inner_text() == ""
    before = found.pixels()
    page.get_by_label("cut the part").select_option("cut z")
    page.get_by_label("place of the cut").fill("90")
    assert page.locator("output[data-test='cut']").inner_text().startswith("z = ")
    assert np.abs(found.pixels() - before).max(axis=2).mean() > 1.0
    top = (T @ [100.0, 60.0, 90.0, 1.0])[:3].tolist()
    seen = "p => { const { x, y } = wpcal.project(p); return wpcal.viewer.surfaceAt(x, y)?.p ?? null; }"
    assert page.evaluate(seen, top) != pytest.approx(top, abs=DRAWN_MM)
    page.get_by_label("cut the part").select_option("no cut")
    assert page.evaluate(seen, top) == pytest.approx(top, abs=DRAWN_MM)


def test_what_is_behind_the_part_does_not_answer(folder: Path, report: Any) -> None:
    hidden = seams(folder)[BEHIND]["frames"][FRAME]["p_mm"]
    assert report.page.evaluate("p => window.wpcal.viewer.isHidden(p)", hidden)
    report.page.mouse.move(*report.project(hidden))
    report.page.wait_for_timeout(200)
    tip = report.page.locator(".tooltip")
    assert tip.is_hidden() or not tip.inner_text().startswith("W3")


@pytest.mark.deep
def test_a_row_of_the_table_brings_its_seam_to_the_front(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    frame = seams(folder)[BEHIND]["frames"][FRAME]["p_mm"]
    assert found.page.evaluate("p => window.wpcal.viewer.isHidden(p)", frame)
    found.page.locator("#seams tbody tr", has_text="W3").first.click()
    found.page.evaluate("() => window.wpcal.viewer.draw()")
    assert not found.page.evaluate("p => window.wpcal.viewer.isHidden(p)", frame)
    spot = found.page.evaluate("p => window.wpcal.project(p)", frame)
    assert spot["inside"]


def test_the_page_unpacks_the_very_bytes_of_the_mesh(folder: Path, report: Any) -> None:
    kept = report.page.evaluate("wpcalViewer.readBlob('part').then((bytes) => Array.from(new Uint8Array(bytes)))")
    assert bytes(kept) == (folder / "part.glb").read_bytes()


@pytest.mark.parametrize(("solid", "p_part", "normal_part"), ON_FACES)
def test_the_part_stands_where_it_was_calibrated(
    folder: Path, report: Any, solid: str, p_part: list[float], normal_part: list[float]
) -> None:
    """A place of a face, seen through the view and back."""
    record = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))
    T = np.array(record["T_base_part"])
    p_base = (T @ [*p_part, 1.0])[:3]
    hit = report.page.evaluate(
        "p => { const { x, y } = wpcal.project(p); return wpcal.viewer.surfaceAt(x, y); }", p_base.tolist()
    )
    assert hit["solid"] == solid
    np.testing.assert_allclose(hit["p"], p_base, rtol=0, atol=DRAWN_MM)
    np.testing.assert_allclose(hit["normal"], T[:3, :3] @ normal_part, rtol=0, atol=DRAWN_RAD)


@pytest.mark.deep
def test_the_factor_of_the_residuals_is_shown(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    shown = found.page.locator("output[data-test='factor']")
    before, first = found.pixels(), shown.inner_text()
    slider = found.page.locator(".slider input")
    slider.fill(str(int(slider.input_value()) + 1))
    assert shown.inner_text() != first
    assert count(found.pixels(), RESIDUAL_PINK) > count(before, RESIDUAL_PINK)


def test_hostile_names_show_as_text(folder: Path, tmp_path: Path, open_page: Any) -> None:
    files = read_result_folder(folder)
    assert files.part_glb is not None
    mesh = read_part_glb(files.part_glb)
    renamed = [SolidMesh(HOSTILE, s.points, s.triangles, s.edges, s.color_rgb) for s in mesh.solids]
    part = write_part_glb(PartMesh(tuple(renamed), mesh.deflection_mm, mesh.angle_rad))
    calibration, records = files.calibration, files.seams
    calibration["points"][0]["name"] = HOSTILE
    calibration["inputs"]["part"]["file"] = HOSTILE
    calibration["issues"] = [{"code": "x", "message": HOSTILE, "ids": []}]
    for seam in records["seams"]:
        seam["name"], seam["solids"], seam["joint"] = HOSTILE, [HOSTILE], HOSTILE
    (tmp_path / "report.html").write_text(build_report(calibration, records, part), encoding="utf-8")
    found = open_page(tmp_path / "report.html")
    assert found.said == []
    assert found.page.evaluate("window.hacked") is None
    assert found.page.locator("img").count() == 0
    assert found.page.locator("h1").inner_text() == HOSTILE
    cells = found.page.locator("#seams tbody tr").first.locator("td").all_inner_texts()
    assert [cells[0], *cells[3:5]] == [HOSTILE, f"{HOSTILE} fillet", HOSTILE]
    assert found.page.locator(".label", has_text=HOSTILE).count() > 0
    found.page.locator("canvas").first.scroll_into_view_if_needed()  # long notes stand above the view
    found.page.mouse.move(*found.project(records["seams"][SEAM]["frames"][FRAME]["p_mm"]))
    found.page.locator(".tooltip").wait_for(state="visible")
    assert found.page.locator(".tooltip strong").inner_text() == HOSTILE


def test_a_calibration_without_mesh_seams_and_predictions(folder: Path, tmp_path: Path, open_page: Any) -> None:
    files = read_result_folder(folder)
    calibration, records = files.calibration, files.seams
    calibration |= {"verdict": "FAIL", "criteria": None}
    calibration["solver"].pop("trace", None)
    records["seams"] = []
    (tmp_path / "report.html").write_text(build_report(calibration, records), encoding="utf-8")
    found = open_page(tmp_path / "report.html")
    assert found.said == []
    assert found.page.locator(".stamp").inner_text() == "FAIL"
    assert found.page.locator("#criteria").count() == 0
    assert "no seam" in found.page.locator("#seams").inner_text()
    assert found.page.locator("input[data-layer='part']").count() == 0


@pytest.mark.deep
def test_points_that_fit_exactly_and_a_closed_seam(tmp_path: Path, open_page: Any) -> None:
    run_wpcal("calibrate", SADDLE / "saddle.step", SADDLE / "taught_exact.csv", "-o", tmp_path / "out")
    found = open_page(tmp_path / "out" / "report.html")
    assert found.said == []
    assert "NaN" not in found.page.locator("#page").inner_html()
    assert found.page.locator(".gauge .value").first.inner_text() == "0.000 mm"


@pytest.mark.deep
def test_the_printer_gets_a_picture_of_the_view(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    found.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    found.page.emulate_media(media="print")
    picture = found.page.locator(".stage img")
    assert picture.is_visible()
    assert picture.evaluate("image => image.decode().then(() => image.naturalWidth)") > 500
    assert found.page.locator(".panel").is_hidden()
    assert found.said == []


def test_paper_has_one_page_with_the_accepted_seams(folder: Path, open_page: Any) -> None:
    found = open_page(folder / "report.html")
    found.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert found.page.pdf(format="A4").count(b"/Type /Page\n") == 1
    found.page.emulate_media(media="print")
    for name, is_shown in {"pose": True, "points": True, "seams": True, "budget": False, "criteria": False}.items():
        assert found.page.locator(f"#{name}").is_visible() == is_shown

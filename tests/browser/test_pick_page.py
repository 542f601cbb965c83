"""The picker from end to end: click features, type values, save; `wpcal calibrate` gives the same result."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.running import FINISHED, run_here

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee"
VALUES = {
    "V2": ("812.29", "-240.62", "165.80"),
    "V4": ("744.70", "-141.51", "168.15"),
    "V14": ("977.41", "-127.90", "172.75"),
    "V12": ("918.99", "-92.01", "253.08"),
}
"""Like those of the published table: values of a robot with two decimals. V14 is computed from the others and then
changed a little."""
TOLERANCE_MM = 0.4


@pytest.fixture(scope="module")
def places(kernel_here: None) -> dict[str, list[float]]:
    """Where the features are, part frame, mm."""
    found = json.loads(run_here("features", TEE / "tee.step", "--json").stdout)["features"]
    return {feature["name"]: feature["p_mm"] for feature in found}


def settled(opened: Any) -> None:
    opened.wait("window.wpcal.idle")


def shown(opened: Any) -> dict[str, str]:
    """The distances in the table, by the row's name."""
    return {
        line.get_attribute("data-name"): line.locator(".distance").inner_text()
        for line in opened.page.locator("#points tbody tr").all()
    }


def seam_errors(opened: Any) -> dict[str, str]:
    return {
        line.get_attribute("data-name"): line.locator("td").nth(3).inner_text()
        for line in opened.page.locator("#seams tbody tr").all()
    }


def calibrated(folder: Path, taught: str, *options: str) -> tuple[dict[str, Any], dict[str, Any]]:
    done = run_here("calibrate", TEE / "tee.step", taught, "-o", "out", *options, cwd=folder)
    assert done.returncode in FINISHED, done.stderr
    return tuple(json.loads((folder / "out" / name).read_text()) for name in ("calibration.json", "seams.json"))  # type: ignore[return-value]


def test_pick_type_save_calibrate(start: Any, open_page: Any, places: dict[str, list[float]], tmp_path: Path) -> None:
    picker = start(TEE / "tee.step", "--tolerance-mm", str(TOLERANCE_MM))
    opened = open_page(picker.url)
    keyboard = opened.page.keyboard
    for name, values in VALUES.items():
        opened.page.mouse.click(*opened.project(places[name]))
        for value in values:  # the pick puts the caret into x, and Enter goes on
            keyboard.type(value)
            keyboard.press("Enter")
    settled(opened)
    on_page, errors_on_page = shown(opened), seam_errors(opened)
    said = opened.page.inner_text("#state")
    opened.page.click("#save")
    opened.wait("document.querySelector('#save-state').textContent.startsWith('saved 4 rows to taught.csv')")

    record, seams = calibrated(tmp_path, "taught.csv", "--tolerance-mm", str(TOLERANCE_MM))
    assert list(on_page) == list(VALUES)
    assert on_page == {point["name"]: f"{point['distance_mm']:.4f}" for point in record["points"]}
    largest = {seam["name"]: max(frame["u95_mm"] for frame in seam["frames"]) for seam in seams["seams"]}
    assert errors_on_page == {
        seam["name"]: f"{largest[seam['name']]:.4f}" if seam["accepted"] else "; ".join(seam["against"])
        for seam in seams["seams"]
    }
    assert record["judgement"]["sentence"][1:] in said

    assert opened.said == []
    assert {address.rsplit("/", 1)[0] + "/" for address in opened.asked} == {picker.url}
    code, out, faults = picker.end()
    assert (code, faults) == (0, "")
    assert out.startswith(f"saved taught.csv; now: wpcal calibrate {TEE / 'tee.step'} taught.csv --tolerance-mm 0.4 -o")


@pytest.mark.deep
def test_the_pointer_names_the_nearest_feature(start: Any, open_page: Any, places: dict[str, list[float]]) -> None:
    opened = open_page(start(TEE / "tee.step").url)
    x, y = opened.project(places["H1"])
    opened.page.mouse.move(x + 12, y + 9)
    opened.wait("!document.querySelector('.tooltip').hidden")
    tip = opened.page.inner_text(".tooltip")
    assert tip.startswith("H1 hole")
    assert "10.000 mm" in tip


@pytest.mark.deep
def test_rows_are_there_at_the_beginning_and_a_wrong_one_is_named(start: Any, open_page: Any) -> None:
    opened = open_page(start(TEE / "tee.step", TEE / "taught.csv", "-o", "taught.csv").url)
    settled(opened)
    assert list(shown(opened)) == ["V2", "V4", "V16", "V12", "V6", "H1"]
    before = shown(opened)
    cell = opened.page.locator("tr[data-name=V4] input[aria-label=y_mm]")
    cell.fill("-14x")
    settled(opened)
    assert opened.page.inner_text("#state") == "V4, y_mm: expected a number, got '-14x'"
    assert "fault" in opened.page.locator("tr[data-name=V4]").get_attribute("class")
    cell.fill("-141.51")
    settled(opened)
    assert shown(opened) == before


@pytest.mark.deep
def test_points_are_suggested_and_wait_for_their_coordinates(start: Any, open_page: Any) -> None:
    opened = open_page(start(TEE / "tee.step", "--sigma-mm", "0.3").url)
    opened.page.click("#suggest")
    opened.wait("document.querySelectorAll('#points tbody tr').length === 4")
    advice = json.loads(run_here("advise", TEE / "tee.step", "--count", "4", "--json").stdout)
    assert list(shown(opened)) == advice["chosen"]["features"]
    assert f"at most {advice['chosen']['error_95_mm']:.3f} mm, on {advice['chosen']['seam']}" in opened.page.inner_text(
        "#save-state"
    )
    opened.page.keyboard.type("812.29")  # the caret stands in x of the first
    assert opened.page.locator("tbody tr").first.locator("input[aria-label=x_mm]").input_value() == "812.29"
    opened.page.click("#suggest")
    opened.wait("document.querySelectorAll('#points tbody tr').length === 5")


@pytest.mark.deep
def test_a_program_is_read_and_its_frame_asked_for(start: Any, open_page: Any, tmp_path: Path) -> None:
    lines = ["DEFDAT TEACH"]
    for name, (x, y, z) in VALUES.items():
        lines.append(f"DECL E6POS X{name}={{X {float(x) - 500:.2f},Y {y},Z {z},A 0.0,B 90.0,C 0.0,S 2,T 35}}")
        lines.append(f'DECL FDAT F{name}={{TOOL_NO 1,BASE_NO 7,IPO_FRAME #BASE,POINT2[] " "}}')
    program = tmp_path / "TEACH.dat"
    program.write_text("\n".join([*lines, "ENDDAT", ""]), encoding="utf-8")
    opened = open_page(start(TEE / "tee.step").url)
    opened.page.locator("#file").set_input_files(program)
    opened.page.locator("#frame input").fill("500,0,0,0,0,0")
    opened.page.locator("#frame button").click()
    opened.wait("document.querySelectorAll('#points tbody tr').length === 4")
    settled(opened)
    x = opened.page.locator("tr[data-name=V2] input[aria-label=x_mm]").input_value()
    assert float(x) == float(VALUES["V2"][0])
    assert all(shown(opened).values())


@pytest.mark.deep
def test_names_that_look_like_markup_stay_names(start: Any, open_page: Any, tmp_path: Path) -> None:
    hostile = "</script><img src=x onerror=window.hacked=1>"
    rows = [f"{name if name != 'V2' else hostile},{','.join(xyz)},{name}" for name, xyz in VALUES.items()]
    (tmp_path / "odd.csv").write_text("\n".join(["name,x_mm,y_mm,z_mm,feature", *rows, ""]), encoding="utf-8")
    opened = open_page(start(TEE / "tee.step", "odd.csv").url)
    settled(opened)
    assert opened.page.evaluate("window.hacked") is None
    assert hostile in shown(opened)


def test_when_the_server_has_ended_the_table_stays(start: Any, open_page: Any) -> None:
    picker = start(TEE / "tee.step", TEE / "taught.csv", "-o", "taught.csv")
    opened = open_page(picker.url)
    settled(opened)
    code, out, faults = picker.end()
    assert (code, out, faults) == (0, "nothing was saved\n", "")
    opened.page.click("#save")
    opened.wait("document.querySelector('#save-state').textContent.includes('no longer answers')")
    assert len(shown(opened)) == 6


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing.step"], "missing.step"),
        ([TEE / "tee.step", "missing.csv"], "missing.csv: no such file"),
        ([TEE / "tee.step", TEE / "tee.step", "-o", "x.csv"], "is a STEP file, expected a table"),
        ([TEE / "tee.step", "-o", "there.csv"], "there.csv: has a header and no rows; give -o and another name"),
        ([TEE / "tee.step", "there.csv"], "there.csv: has a header and no rows"),
        ([TEE / "tee.step", "-o", "no/such/x.csv"], "no such folder"),
        ([TEE / "truth.json"], "truth.json"),
    ],
)
def test_wrong_use_is_one_line(arguments: list[str | Path], said: str, tmp_path: Path) -> None:
    (tmp_path / "there.csv").write_text("mine", encoding="utf-8")
    done = run_here("pick", *arguments, "--no-browser", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert said in done.stderr
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("there.csv", "mine")]


@pytest.mark.deep
def test_a_tablet_in_the_network_has_the_whole_page(start: Any, open_page: Any) -> None:
    """At an address of the network browsers take functions away; here the page is at a name that stands for one."""
    picker = start(TEE / "tee.step", "--host", "localhost")
    opened = open_page(picker.url)
    opened.page.add_init_script(
        "delete Crypto.prototype.randomUUID;Object.defineProperty(Navigator.prototype, 'clipboard', {value: undefined})"
    )
    opened.page.reload()
    opened.wait("Boolean(window.wpcal && window.wpcal.ready)")
    assert opened.page.evaluate("[crypto.randomUUID === undefined, navigator.clipboard === undefined]") == [True, True]
    opened.page.click("#add")
    opened.page.keyboard.type("V2")
    settled(opened)
    assert list(shown(opened)) == ["T1"]
    opened.page.click("#copy")
    assert "not copied" in opened.page.inner_text("#save-state")
    assert opened.said == []

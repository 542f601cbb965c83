"""The public lists of welds: their form, their lines, the scorer, and scores that never fall."""

import importlib.util
import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tests.benchmarks.bench_seams import main, seams_of
from tests.benchmarks.welds.check import off_members
from tests.benchmarks.welds.lists import FOLDER, OPTIONAL, Weld, line, read_record, sha256, to_json, welds_of
from tests.benchmarks.welds.parts.plates import fused_bracket, tab_plates
from tests.benchmarks.welds.results import LAST, PAGE, read_results, total
from tests.benchmarks.welds.score import score
from tests.few import few

BLIND = Path(__file__).parents[3] / "shared" / "blind"
LISTS = {path.stem: read_record(path) for path in sorted((FOLDER / "lists").glob("*.json"))}
HERE = {name: record for name, record in LISTS.items() if "address" not in record["part"]}
QUICK = (
    "bent-sheet",
    "casting",
    "bolted-post",
    "fused-bracket",
    "lap-ladder",
    "machined-block",
    "pipe-stand",
    "rods-in-plate",
    "rounded-frame",
    "skewed-ribs",
    "tab-plates",
)
"""Parts whose seams are searched in CI, less than half a second each."""
SHIFTED_MM = 1.0  #: How far made-up seams lie from the lists: within the tolerance of every weld.


def test_lists_have_the_form_that_the_schema_says() -> None:
    schema = json.loads((FOLDER / "schema.json").read_text(encoding="utf-8"))
    validator = jsonschema.Draft202012Validator(schema)
    for name, record in LISTS.items():
        validator.validate(record)
        assert record["name"] == name
        bodies = {body["name"] for body in record["bodies"]}
        names = [weld["id"] for weld in record["welds"]]
        assert len(set(names)) == len(names), name
        for weld, item in zip(welds_of(record), record["welds"], strict=True):
            assert set(weld.members) <= bodies, (name, weld.name)
            assert weld.closed is item["closed"], (name, weld.name)
            assert weld.length_mm == pytest.approx(item["length_mm"], abs=0.05), (name, weld.name)
        assert to_json(record) == (FOLDER / "lists" / f"{name}.json").read_text(encoding="utf-8"), name


def test_at_least_twenty_parts_and_ten_of_them_made_by_others() -> None:
    made_by_others = [name for name, record in LISTS.items() if not record["part"]["source"].startswith("generated")]
    assert len(LISTS) >= 20
    assert len(made_by_others) >= 10


@pytest.mark.parametrize("name", few(HERE, 5))
def test_lines_lie_on_the_members_that_they_name(name: str) -> None:
    step = FOLDER / HERE[name]["part"]["file"]
    assert sha256(step) == HERE[name]["part"]["sha256"]
    welds = welds_of(HERE[name])
    off = off_members(step, welds)
    assert [weld.name for weld in welds if off[weld.name] > weld.tol_mm] == []


@pytest.mark.parametrize("build", [fused_bracket, tab_plates])
def test_a_generator_gives_the_list_that_is_recorded(build: Any) -> None:
    part = build()
    assert [weld.to_record() for weld in part.welds] == LISTS[part.name]["welds"]


@pytest.mark.parametrize("name", few(QUICK, 2))
def test_scores_never_fall_below_the_recorded_ones(name: str) -> None:
    recorded = read_results(LAST)[name]
    now = score(name, welds_of(HERE[name]), seams_of(FOLDER / HERE[name]["part"]["file"])).to_record()
    for cls in ("sure", "probable"):
        assert now[cls]["found"] >= recorded[cls]["found"], now["missed"]
        assert now[cls]["found_mm"] >= recorded[cls]["found_mm"] - 1.0, now["missed"]
    assert now["wrong_mm"] <= recorded["wrong_mm"] + 1.0, now["wrong_seams"]


def test_the_page_shows_the_recorded_scores() -> None:
    assert total() in PAGE.read_text(encoding="utf-8")


def made_up_seam(name: str, points: Any, *, closed: bool = False) -> dict[str, Any]:
    facts = {"name": name, "joint": "tee", "weld": "fillet", "solids": ["a", "b"], "length_mm": 0.0}
    return {**facts, "accepted": True, "closed": closed, "frames": [{"p_mm": list(p)} for p in points]}


def test_a_weld_is_found_right_optional_or_missed() -> None:
    sure = Weld("sure", ("a", "b"), "tee fillet", "A", line((0, 0, 0), (100, 0, 0)))
    flare = Weld("flare", ("a", "b"), "flare bevel", "B", line((0, 50, 0), (100, 50, 0)), 6.5)
    wrap = Weld("wrap", ("a", "b"), "wrap", "O", line((0, 0, 0), (0, 8, 0)))
    seams = [
        made_up_seam("W1", [(0, 1, 0), (95, 1, 0)]),
        made_up_seam("W2", [(0, 56, 0), (80, 56, 0)]),
        made_up_seam("W3", [(0, 0, 1), (0, 8, 1)]),
        made_up_seam("W4", [(50, -40, 0), (50, 40, 0)]),
        {**made_up_seam("W5", [(0, 90, 0), (90, 90, 0)]), "accepted": False},
    ]
    found = score("made up", (sure, flare, wrap), seams)
    assert (found.sure.found, found.probable.found) == (1, 0)
    assert found.probable.found_mm == pytest.approx(80, abs=0.5 + 4.0)
    assert (found.accepted, found.right, found.optional, found.wrong) == (4, 2, 1, 1)
    assert [item["name"] for item in found.wrong_seams] == ["W4"]
    assert [item["id"] for item in found.missed] == ["flare"]


def test_nothing_accepted_finds_nothing() -> None:
    weld = Weld("sure", ("a",), "tee fillet", "A", line((0, 0, 0), (100, 0, 0)))
    found = score("empty", (weld,), [])
    assert (found.sure.found, found.sure.of, found.accepted, found.wrong_mm) == (0, 1, 0, 0)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # the other scorer leaves files open
@pytest.mark.skipif(not BLIND.is_dir(), reason="../shared is not here")
@pytest.mark.parametrize("name", few(["iron_Footer_Type_U_L70", "afpm_boom_vane", "wb_bench"], 1))
def test_the_scorer_counts_as_the_one_of_the_blind_test(name: str, tmp_path: Path) -> None:
    truth = BLIND / "truth" / f"{name}.json"
    items = json.loads(truth.read_text(encoding="utf-8"))["seams"]
    welds = tuple(
        Weld(item["id"], (item["a"], item["b"]), item["kind"], item["cls"], np.array(item["points"]), item["tol"])
        for item in items
    )
    rng = np.random.default_rng(16)
    seams = []
    for number, weld in enumerate(welds):
        kept = weld.points[: max(2, round(len(weld.points) * rng.choice([0.4, 0.92, 1.0])))]
        way = rng.normal(size=3)
        far = rng.choice([0.0, SHIFTED_MM, weld.tol_mm + 0.2, 9.0])
        seams.append(
            made_up_seam(f"W{number}", kept + far * way / np.linalg.norm(way), closed=len(kept) == len(weld.points))
        )
    path = tmp_path / "seams.json"
    path.write_text(json.dumps({"seams": [{**seam, "accepted": k % 5 > 0} for k, seam in enumerate(seams)]}))
    spec = importlib.util.spec_from_file_location("blind_score", BLIND / "score.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    theirs = module.score(str(truth), str(path), False)
    ours = score(name, welds, json.loads(path.read_text())["seams"])
    for cls, key in ((ours.sure, "A"), (ours.probable, "B")):
        assert (cls.found, cls.of) == tuple(theirs[key][:2])
        assert cls.found_mm == pytest.approx(theirs[key][2], abs=0.06)
    for key in ("accepted", "right", "optional", "wrong"):
        assert getattr(ours, key) == theirs[key]
    assert ours.right_mm == pytest.approx(theirs["right_len"], abs=0.06)
    assert ours.optional_mm == pytest.approx(theirs["opt_len"], abs=0.06)


def test_the_table_the_faults_and_own_lists(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    weld = next(weld for weld in LISTS["lap-ladder"]["welds"] if weld["class"] != OPTIONAL)
    record = {**LISTS["lap-ladder"], "name": "own", "welds": [weld]}
    (tmp_path / "own.json").write_text(to_json(record), encoding="utf-8")
    seams = tmp_path / "seams.json"
    seams.write_text(json.dumps({"seams": [made_up_seam("W1", [(0, 0, 99), (9, 0, 99)])]}), encoding="utf-8")
    shown = main(["own", "--lists", str(tmp_path), "--seams", str(seams)])
    assert shown.row_count == 1
    out = capsys.readouterr().out
    assert "own: missed A" in out
    assert "own: wrong W1" in out
    assert main(["own", "--lists", str(tmp_path), "--seams", str(seams), "--json"]) is None
    assert json.loads(capsys.readouterr().out)[0]["wrong"] == 1
    with pytest.raises(SystemExit, match="no list"):
        main(["nobody", "--lists", str(tmp_path)])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "is not JSON"),
        (json.dumps({**LISTS["pallet"], "welds": [{"id": "a"}]}), r"\$\.welds\[0\]: 'members' is a required property"),
    ],
)
def test_an_own_list_that_is_wrong_is_one_line(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "own.json").write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit, match=says):
        main(["--lists", str(tmp_path)])

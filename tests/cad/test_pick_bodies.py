"""Bodies that may have moved, in the picker: answer, command and what is kept are those of `wpcal calibrate`."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from cad.pick.draft import Draft, Keyed, read_draft
from cad.pick.opening import find_table, start_table
from cad.session.part import PickPart, read_pick_part
from cad.session.session import ERROR_DIGITS, PickSession
from cad.workpiece.bodies import BodiesOptions, read_bodies
from cad.workpiece.calibrate import calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.moved_record import bodies_record
from cad.workpiece.moving import MovingChoice
from cad.workpiece.seams import SeamChoice
from tests.few import few
from wpcal.calibrate import TeachingError
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions

UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"
TAUGHT = UPRIGHTS / "taught.csv"
SHOWN_MM = 0.5 * 10.0**-ERROR_DIGITS + 1e-15  #: Predicted errors are rounded for the page.
ROUND_OFF = 1e-9


@pytest.fixture(scope="module")
def part() -> PickPart:
    """The uprights as the picker reads them, once."""
    return read_pick_part(UPRIGHTS / "uprights.step", options=SeamOptions(), choice=SeamChoice())


@pytest.mark.parametrize(
    "moving",
    few(
        [
            MovingChoice(True, 0.5, 2.0, bending_mm=0.5),
            MovingChoice(True, tack_mrad=5.0, keeps_contacts=True),
            MovingChoice(True),
        ],
        0,
    ),
)
def test_the_numbers_are_those_of_calibrate(part: PickPart, moving: MovingChoice) -> None:
    groups = read_bodies(UPRIGHTS / "bodies.json") if moving.tack_mm is None else ()
    options = CalibrateOptions(teaching=TeachingError(sigma_mm=0.2))
    session = PickSession(part, options, moving=moving, groups=groups)
    rows, _ = session.read(TAUGHT.read_bytes(), name="taught.csv")
    answer = session.fit(rows)
    stated = replace(
        BodiesOptions.of(moving.tack_mm, moving.tack_mrad, groups),
        keeps_contacts=moving.keeps_contacts,
        bending_mm=moving.bending_mm,
    )
    found = calibrate_workpiece(
        UPRIGHTS / "uprights.step",
        TAUGHT,
        options=CalibrateOptions(teaching=TeachingError(sigma_mm=0.2), bodies=stated),
    )
    assert found.moved is not None
    expected = bodies_record(found.moved, found.workpiece.graph)
    assert answer["bodies"]["sentence"] == expected["sentence"]
    for ours, theirs in zip(answer["bodies"]["bodies"], expected["bodies"], strict=True):
        for field in ("moved_mm", "turned_mrad", "tack_mm", "tack_mrad", "sigmas"):
            assert ours[field] == pytest.approx(theirs[field], abs=ROUND_OFF)
    for ours, theirs in zip(answer["u95_mm"], found.candidate_u95_mm, strict=True):
        assert ours == pytest.approx(theirs.tolist(), abs=SHOWN_MM)
    assert answer["judgement"]["sentence"] == found.result.judgement.sentence
    assert answer["moving"] == moving.to_record()


def test_off_is_the_rigid_fit(part: PickPart) -> None:
    session = PickSession(part)
    rows, _ = session.read(TAUGHT.read_bytes(), name="taught.csv")
    assert "bodies" not in session.fit(rows)


def test_the_choice_is_kept_with_the_table_and_said_in_the_command(part: PickPart, tmp_path: Path) -> None:
    out = tmp_path / "taught.csv"
    table, _ = start_table(find_table(out), part, part_step=UPRIGHTS / "uprights.step")
    chosen = MovingChoice(True, tack_mm=0.7)
    assert table.choose(chosen) == {"moving": chosen.to_record(), "warning": ""}
    assert find_table(out).moving == chosen
    again, _ = start_table(find_table(out), part, part_step=UPRIGHTS / "uprights.step")
    assert again.moving == chosen
    assert chosen.words(None) == ["--bodies", "--tack-mm", "0.7"]
    assert MovingChoice(True).words(Path("b.json")) == ["--bodies", "b.json"]
    with_contacts = MovingChoice(True, keeps_contacts=True, contact_mm=0.2, bending_mm=0.5)
    assert with_contacts.words(None) == ["--bodies", "--contacts", "0.2", "--bending", "0.5"]
    assert MovingChoice.from_record(with_contacts.to_record()) == with_contacts
    assert MovingChoice(False, 0.7).words(None) == []


def test_a_draft_of_before_is_read(tmp_path: Path) -> None:
    draft = Draft(Keyed.of_rows(find_table(tmp_path / "t.csv").rows), "a.step", "0" * 64)
    record = json.loads(draft.to_json())
    assert "bodies" not in record
    path = tmp_path / "t.csv.draft"
    path.write_text(draft.to_json(), encoding="utf-8")
    assert read_draft(path).moving == MovingChoice()


@pytest.mark.parametrize(
    ("record", "words"),
    [
        ({"is_on": True, "tack_mm": "0"}, "tack tolerance in mm must be a positive number"),
        ({"is_on": True, "tack_mrad": -3}, "tack tolerance in mrad must be a positive number"),
        ({"is_on": True, "tack_mm": "a lot"}, "expected a number"),
        ({"is_on": True, "contact_mm": "-1"}, "must be a positive number"),
        ({"is_on": "yes"}, "expected is_on"),
    ],
)
def test_a_wrong_choice_is_one_line(record: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        MovingChoice.from_record(record)


def test_a_decimal_comma_is_understood() -> None:
    assert MovingChoice.from_record({"is_on": True, "tack_mm": "0,5", "tack_mrad": ""}).tack_mm == 0.5

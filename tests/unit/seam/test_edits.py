"""Decisions about seams, given back in seams.json: through the library, on saved graphs."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.schemas import schema_text
from wpcal.seam import Seam, SeamOptions, StepOptions
from wpcal.seam.edit import apply_edits, read_edits
from wpcal.seam.record import seams_from_record, seams_record

ROUND_OFF_MM = 1e-9

Edit = Callable[[list[dict[str, Any]]], None]


def edited_file(folder: Path, edit: Edit, name: str = "tee") -> Path:
    record = json.loads(to_json(seams_record(saved_seams(name))))
    edit(record["seams"])
    jsonschema.validate(record, json.loads(schema_text("wpcal/seams/1")))
    path = folder / "seams.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


def after(path: Path, name: str = "tee", options: SeamOptions | None = None) -> dict[str, Seam]:
    graph, options = saved_graph(name), options or SeamOptions()
    trimmed = TrimmedFaces.of(graph)
    seams = saved_seams(name, options)
    return {seam.name: seam for seam in apply_edits(graph, trimmed, seams, read_edits(path), options)}


def test_a_file_without_edits_changes_nothing(tmp_path: Path) -> None:
    path = edited_file(tmp_path, lambda seams: None)
    assert read_edits(path) == ()
    assert to_json(seams_record(tuple(after(path).values()))) == to_json(seams_record(saved_seams("tee")))


def test_reject_reverse_name_and_range(tmp_path: Path, golden: Any) -> None:
    def edit(seams: list[dict[str, Any]]) -> None:
        seams[0]["edit"] = {"reject": True}
        seams[1]["edit"] = {"reverse": True, "name": "front"}
        seams[2]["edit"] = {"range_mm": [20, 120.5]}

    W2, W3 = saved_seams("tee")[1:3]
    seams = after(edited_file(tmp_path, edit))
    assert list(seams) == ["W1", "front", "W3", "W4"]
    assert not seams["W1"].accepted
    assert "rejected by hand" in seams["W1"].reasons
    back = seams["front"].frames
    np.testing.assert_allclose(back.p, W2.frames.p[::-1], rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(back.R[:, :, 0], -W2.frames.R[::-1, :, 0], rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(back.R[:, :, 2], W2.frames.R[::-1, :, 2], rtol=0, atol=ROUND_OFF_MM)
    part = seams["W3"]
    assert part.length_mm == pytest.approx(100.5, rel=0, abs=ROUND_OFF_MM)
    x = W3.frames.R[0, :, 0]
    np.testing.assert_allclose(part.frames.p[[0, -1]], W3.frames.p[0] + np.outer([20, 120.5], x), rtol=0, atol=1e-9)
    golden(seams)


def test_a_part_of_a_loop_begins_and_ends_on_the_curve(tmp_path: Path) -> None:
    def edit(seams: list[dict[str, Any]]) -> None:
        seams[0]["edit"] = {"range_mm": [10, 60], "accept": True}

    (whole, *_) = saved_seams("saddle")
    part = after(edited_file(tmp_path, edit, "saddle"), "saddle")["W1"]
    assert (whole.closed, part.closed, part.accepted) == (True, False, True)
    assert part.length_mm == pytest.approx(50.0, rel=0, abs=1e-9)
    np.testing.assert_allclose(np.hypot(*part.frames.p[:, :2].T), 25.0, rtol=0, atol=1e-6)


def test_two_stretches_of_one_seam(tmp_path: Path, golden: Any) -> None:
    def edit(seams: list[dict[str, Any]]) -> None:
        seams.append(json.loads(json.dumps(seams[1])))
        seams[1]["edit"] = {"name": "near", "range_mm": [0, 30]}
        seams[-1]["edit"] = {"name": "far", "range_mm": [100, 150]}

    seams = after(edited_file(tmp_path, edit))
    assert [(name, round(seam.length_mm, 9)) for name, seam in seams.items()][1:3] == [("near", 30.0), ("far", 50.0)]
    golden(seams)


def test_the_result_can_be_given_back_again_and_under_other_options(tmp_path: Path) -> None:
    def edit(seams: list[dict[str, Any]]) -> None:
        seams[1]["edit"] = {"reverse": True, "name": "front", "range_mm": [10, 20]}

    once = after(edited_file(tmp_path, edit))
    again = tmp_path / "again.json"
    again.write_text(to_json(seams_record(tuple(once.values()))), encoding="utf-8")
    assert to_json(seams_record(tuple(after(again).values()))) == again.read_text()
    finer = after(again, options=SeamOptions(steps=StepOptions(max_step_mm=1.0)))
    assert len(finer["front"].frames) == 11
    assert seams_from_record(json.loads(again.read_text()), path="again")[1].name == "front"


def set_edit(value: Any) -> Edit:
    def edit(seams: list[dict[str, Any]]) -> None:
        seams[0]["edit"] = value

    return edit


def move_start(seams: list[dict[str, Any]]) -> None:
    seams[0]["edit"] = {"reject": True}
    seams[0]["candidate"]["start_part_mm"][0] += 1.0


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (move_start, "seam W1, 8.0 mm long from (26.0, 56.0, 10.0) in part coordinates, is not found on this part"),
        (set_edit({"range_mm": [0, 9]}), "range_mm ends at 9, but the seam at 8.000 mm"),
        (set_edit({"name": "W2"}), "two seams would be called 'W2'"),
    ],
)
def test_an_edit_that_does_not_fit_the_part_is_refused(edit: Edit, message: str, tmp_path: Path) -> None:
    path = edited_file(tmp_path, edit)
    with pytest.raises(InputError) as caught:
        after(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ({"acept": True}, "unknown key 'acept'; expected accept, reject, reverse, name, range_mm"),
        ({"accept": True, "reject": True}, "accept and reject exclude each other"),
        ({"accept": "yes"}, "edit.accept: expected true or false, got 'yes'"),
        ({"range_mm": [5]}, "edit.range_mm: expected 2 entries, got 1"),
        ({"range_mm": [5, 5]}, "range_mm must rise from 0 or more, got [5, 5]"),
        ({"name": " "}, "name must be a text, got ' '"),
        (["reject"], "edit: expected an object"),
    ],
)
def test_an_edit_that_breaks_the_form_is_refused(value: Any, message: str, tmp_path: Path) -> None:
    record = json.loads(to_json(seams_record(saved_seams("tee"))))
    record["seams"][0]["edit"] = value
    path = tmp_path / "seams.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    with pytest.raises(FormatError) as caught:
        read_edits(path)
    assert message in str(caught.value)
    assert "seam W1" in str(caught.value)

"""What a script gives and gets: points in any of five forms, welds apart from candidates, a short summary."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from build123d import Box, Pos, Vector

import cad
from cad.batch.jobs import result_of
from cad.workpiece.calibrate import WorkpieceCalibration
from wpcal.core.errors import InputError
from wpcal.taught.table import taught_points

TOUCHED = {
    "V2": (900.20, 99.74, 60.04),
    "V4": (864.48, 214.60, 59.98),
    "V16": (1055.40, 273.72, 59.91),
    "V12": (1048.60, 212.88, 139.96),
}


@pytest.fixture(scope="module")
def found() -> WorkpieceCalibration:
    plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
    plate.label, web.label = "plate", "web"
    return cad.calibrate_workpiece([plate, web], TOUCHED)


def test_seams_are_the_welds_and_candidates_are_all(found: WorkpieceCalibration) -> None:
    assert [seam.name for seam in found.candidates] == ["W1", "W2", "W3", "W4"]
    assert [seam.name for seam in found.seams] == ["W2", "W3"]
    assert [len(u95) for u95 in found.u95_mm] == [len(seam.frames) for seam in found.seams]
    assert len(found.seams_record()["seams"]) == 4


def test_printed_it_is_a_summary(found: WorkpieceCalibration) -> None:
    assert len(repr(found).splitlines()) <= 10
    assert repr(found).startswith(f"{found.result.verdict}: 2 solids")
    assert "<iframe" in found._repr_html_()


def test_of_seams_that_are_equal_but_for_round_off_all_name_that_of_the_verdict(found: WorkpieceCalibration) -> None:
    told = found.result.judgement.seam
    tied = replace(
        found, candidate_u95_mm=tuple(np.array([0.2 + 1e-15 * (seam.name != told)]) for seam in found.candidates)
    )
    assert f"worst seam {told}: 0.200 mm" in repr(tied)
    assert result_of(tied)["worst_seam"] == told


def test_every_part_of_it_is_a_line(found: WorkpieceCalibration) -> None:
    for each in (found.workpiece, found.result, found.seams[0], found.seams[0].frames):
        assert len(repr(each)) < 100
    assert repr(found.seams[0]) == "Seam(W2: tee, plate + web, 150.0 mm, accepted)"


def test_planes_are_of_a_seam_or_of_its_frames(found: WorkpieceCalibration) -> None:
    seam = found.seams[0]
    assert len(cad.seam_planes(seam)) == len(cad.seam_locations(seam.frames)) == len(seam.frames)
    with pytest.raises(InputError, match=r"expected a seam or its frames, got WorkpieceCalibration"):
        cad.seam_planes(found)  # type: ignore[arg-type]


class Frame(SimpleNamespace):
    """A table as pandas has one."""

    def __getitem__(self, name: str) -> Any:
        return self.columns[name]


def test_a_table_in_memory_means_what_its_file_means() -> None:
    """Which points only test the fit, how exact each is, and what was touched: none of it may be lost."""
    table = {
        "Name": ["V2", "V4", "top"],
        **{f"{x} [mm]": [1.25, 2.5, 3.75] for x in "XYZ"},
        "feature": ["V2", "V4", float("nan")],
        "use": ["yes", "check", None],
        "sigma_mm": [0.1, 0.2, 0.3],
        "kind": ["point", "point", "plane"],
        **{f"model_{x}_mm": [float("nan")] * 2 + [7.0] for x in "xyz"},
    }
    taught = taught_points(Frame(columns=table))  # type: ignore[arg-type]
    assert (taught.features, taught.use) == (("V2", "V4", ""), ("yes", "check", "yes"))
    assert [kind.value for kind in taught.kinds] == table["kind"]
    assert (taught.p_part[2].tolist(), taught.covariances[1, 0, 0]) == ([7.0] * 3, pytest.approx(0.04))  # type: ignore[index]


def test_points_come_in_any_form(tmp_path: Path) -> None:
    names, p = list(TOUCHED), np.array(list(TOUCHED.values()))
    rows = "".join(f"{name},{x},{y},{z}\n" for name, (x, y, z) in TOUCHED.items())
    (tmp_path / "taught.csv").write_text("name,x_mm,y_mm,z_mm\n" + rows)
    table = {"name": names, "x_mm": p[:, 0], "y_mm": p[:, 1], "z_mm": p[:, 2]}
    vectors = {name: Vector(*position) for name, position in TOUCHED.items()}
    for given in (TOUCHED, vectors, Frame(columns=table), str(tmp_path / "taught.csv")):
        taught = taught_points(given)  # type: ignore[arg-type]
        assert (taught.names, taught.p_base.tolist()) == (tuple(names), p.tolist())
    alone = taught_points(p)
    assert (alone.names, alone.features) == (("P1", "P2", "P3", "P4"), ("",) * 4)
    assert taught_points(alone) is alone


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"V1": (1, 2)}, "taught points"),
        ({"V1": (1, 2, "x")}, "taught points"),
        ([[1, 2, float("nan")]], "taught points"),
        (Frame(columns={"x_mm": [1]}), "missing column name"),
        (Frame(columns={"name": [1], "x_mm": [1], "X [mm]": [2], "y_mm": [3], "z_mm": [4]}), "'x_mm' appears twice"),
        (Frame(columns={"name": [], "x_mm": [], "y_mm": [], "z_mm": []}), "no rows"),
        ({1: (1, 2, 3), 2: (4, 5)}, "taught points"),
        (None, "taught points"),
    ],
)
def test_what_is_no_points_is_one_line(given: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        taught_points(given)  # type: ignore[arg-type]

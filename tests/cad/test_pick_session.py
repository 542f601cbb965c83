"""What the picker says of rows is what `wpcal calibrate` says of the file that it saves."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS, Rows
from cad.session.session import ERROR_DIGITS, PickSession, fault_record
from cad.workpiece.calibrate import calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.moving import MovingChoice
from tests.few import few
from wpcal.calibrate import Criterion, TeachingError
from wpcal.core.errors import FormatError, GeometryError, InputError
from wpcal.touch.advice import advise, advise_set

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
SHOWN_MM = 0.5 * 10.0**-ERROR_DIGITS + 1e-15  #: Predicted errors are rounded for the page.
FIRST_ORDER = 1e-3  #: Relative: the promise is at the model points, the fit at the pose that it found.
FRAME = (500.0, 100.0, 50.0)
KRL = """DEFDAT TEACH
DECL E6AXIS HOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}
DECL E6POS XV2={X 312.29,Y -340.62,Z 115.80,A 0.0,B 90.0,C 0.0,S 2,T 35}
DECL FDAT FV2={TOOL_NO 1,BASE_NO 7,IPO_FRAME #BASE,POINT2[] " "}
DECL E6POS XP9={X 244.70,Y -241.51,Z 118.15,A 0.0,B 90.0,C 0.0,S 2,T 35}
DECL FDAT FP9={TOOL_NO 1,BASE_NO 7,IPO_FRAME #BASE,POINT2[] " "}
ENDDAT
"""


@pytest.fixture
def part(tee_for_the_picker: PickPart) -> PickPart:
    return tee_for_the_picker


def opened(part: PickPart, file: str = "taught.csv", **more: Any) -> tuple[PickSession, Rows]:
    session = PickSession(part, **more)
    return session, session.read((TEE / file).read_bytes(), name=file)[0]


@pytest.mark.parametrize(
    ("file", "options"),
    few(
        [
            ("taught_blunder.csv", CalibrateOptions(criterion=Criterion.LEAST_SQUARES)),
            ("touches_321.csv", CalibrateOptions(ball_mm=1.0, teaching=TeachingError(sigma_mm=0.1))),
            ("taught.csv", CalibrateOptions()),
            ("taught.csv", CalibrateOptions(teaching=TeachingError(sigma_mm=0.2), tolerance_mm=0.1, seed=5)),
        ],
        2,
    ),
)
def test_the_numbers_are_those_of_calibrate(
    part: PickPart, file: str, options: CalibrateOptions, tmp_path: Path
) -> None:
    session, rows = opened(part, file, options=options)
    found = session.fit(rows)
    (tmp_path / "saved.csv").write_text(rows.to_csv(), encoding="utf-8")
    expected = calibrate_workpiece(TEE / "tee.step", tmp_path / "saved.csv", options=options)
    record = expected.to_record()
    for key in ("T_base_part", "objective_mm", "lower_bound_mm", "verdict", "criterion", "criterion_advice"):
        assert found[key] == record[key], key
    for point, other in zip(found["points"], record["points"], strict=True):
        assert {key: point[key] for key in other} == other
        assert rows.cells[point["row"]][0] == other["name"]
    for u95, other in zip(found["u95_mm"], expected.candidate_u95_mm, strict=True):
        np.testing.assert_allclose(u95, other, rtol=0, atol=SHOWN_MM)


def test_planned_touches_promise_what_their_fit_then_says(part: PickPart) -> None:
    options = CalibrateOptions(
        criterion=Criterion.LEAST_SQUARES, ball_mm=1.0, teaching=TeachingError(sigma_mm=0.1), tolerance_mm=5.0
    )
    session, rows = opened(part, "touches_321.csv", options=options)
    fitted = session.fit(rows)
    places = [rows.columns.index(name) for name in ("x_mm", "y_mm", "z_mm")]
    waiting = [["" if k in places else cell for k, cell in enumerate(row)] for row in rows.cells]
    promised = session.promise(Rows(rows.columns, tuple(map(tuple, waiting))))
    of_seam = {seam.name: max(u95) for seam, u95 in zip(part.seams, fitted["u95_mm"], strict=True) if seam.accepted}
    assert abs(promised["error_95_mm"] - max(of_seam.values())) <= FIRST_ORDER * max(of_seam.values())
    assert promised["seam"] == max(of_seam, key=lambda name: of_seam[name])
    model = np.array([[float(row[rows.columns.index(f"model_{a}_mm")]) for a in "xyz"] for row in rows.cells])
    np.testing.assert_allclose([touch["p_mm"] for touch in promised["touches"]], model, rtol=0, atol=1e-9)
    normals = [[0, 0, 1]] * 3 + [[0, -1, 0]] * 2 + [[-1, 0, 0]]
    np.testing.assert_allclose([touch["normal"] for touch in promised["touches"]], normals, rtol=0, atol=1e-9)
    fewer = session.promise(Rows(rows.columns, tuple(map(tuple, waiting[:5]))))
    assert "slides along (1 0 0)" in fewer["free"]
    assert fewer["error_95_mm"] is None
    unused = Rows(rows.columns, tuple(tuple("no" if cell == "yes" else cell for cell in row) for row in waiting))
    assert session.promise(unused)["touches"] == []


def test_a_click_near_a_border_is_refused_with_what_to_do(part: PickPart) -> None:
    session = PickSession(part)
    assert session.touch(np.array([40.0, 0.1, 5.2]), np.array([0.0, -1.0, 0.0]))["kind"] == "plane"
    with pytest.raises(InputError, match=r"0\.3 mm from its border; click farther inside, or the edge"):
        session.touch(np.array([40.0, 0.3, 10.0]), np.array([0.0, 0.0, 1.0]))


def test_residuals_in_the_part_are_those_in_the_base_turned(part: PickPart) -> None:
    session, rows = opened(part)
    found = session.fit(rows)
    T = np.array(found["T_base_part"])
    for point in found["points"]:
        fitted = T[:3, :3] @ (np.array(point["p_part_mm"]) + point["residual_part_mm"]) + T[:3, 3]
        np.testing.assert_allclose(fitted, point["p_base_mm"], rtol=0, atol=1e-9)


def test_rows_that_wait_change_nothing(part: PickPart) -> None:
    session, rows = opened(part)
    waiting = tuple("V8" if column in ("name", "feature") else "" for column in rows.columns)
    more = Rows(rows.columns, (waiting, *rows.cells))
    assert session.fit(more)["T_base_part"] == session.fit(rows)["T_base_part"]
    assert [point["row"] for point in session.fit(more)["points"]] == [1, 2, 3, 4, 5, 6]


def test_points_without_names_are_found(part: PickPart) -> None:
    session, rows = opened(part, "taught_exact.csv")
    names = [row[rows.columns.index("feature")] for row in rows.cells]
    blind = Rows(
        rows.columns,
        tuple(
            tuple("" if column == "feature" else cell for column, cell in zip(rows.columns, row, strict=True))
            for row in rows.cells
        ),
    )
    found = session.fit(blind)
    assert [found["features"][row] for row in range(len(names))] == names


def test_a_program_in_a_frame_that_is_not_known_asks_for_it(part: PickPart) -> None:
    session = PickSession(part)
    with pytest.raises(FormatError) as caught:
        session.read(KRL.encode(), name="TEACH.dat")
    assert fault_record(caught.value)["code"] == "user-frame-missing"
    rows, left_out = session.read(KRL.encode(), name="TEACH.dat", uframe=",".join(map(str, (*FRAME, 0, 0, 0))))
    cells = [dict(zip(rows.columns, row, strict=True)) for row in rows.cells]
    assert [(cell["name"], cell["feature"], float(cell["x_mm"])) for cell in cells] == [
        ("V2", "V2", 812.29),
        ("P9", "", 744.70),
    ]
    (home,) = left_out
    assert home.startswith("HOME: is stored as joint angles")


def test_points_on_a_line_are_refused(part: PickPart) -> None:
    rows = Rows(NEW_COLUMNS, tuple((f"T{i}", str(10 * i), "0", "0", f"V{i}", "yes") for i in (2, 4, 16)))
    with pytest.raises(GeometryError):
        PickSession(part).fit(rows)


def named(*names: str, use: str = "yes") -> Rows:
    return Rows(NEW_COLUMNS, tuple((name, "", "", "", name, use) for name in names))


@pytest.mark.deep
def test_suggested_points_promise_what_advise_promises(part: PickPart) -> None:
    session = PickSession(part, CalibrateOptions(teaching=TeachingError(sigma_mm=0.2)))
    seams = [seam for seam in part.seams if seam.accepted]
    candidates = [item for item in part.touchables if item.feature.kind.is_point]
    expected = advise(candidates, seams, points=4, sigma_mm=0.2)
    found = session.suggest(Rows())
    assert tuple(found["features"]) == expected.chosen.names
    assert (found["error_95_mm"], found["seam"]) == (expected.chosen.error_95_mm, expected.chosen.seam)
    assert len(session.suggest(named(*found["features"]))["features"]) == 1
    more = partial(advise_set, candidates, seams, points=5, sigma_mm=0.2, have=expected.chosen.features)
    assert [len(more(shares=each).features) for each in ((1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))] == [5, 7, 6]


def test_what_was_touched_is_not_suggested_and_no_point_is_said_to_help_that_does_not(part: PickPart) -> None:
    session = PickSession(part)
    first = session.suggest(Rows())["features"]
    others = session.suggest(named(*first, use="check"))
    assert len(others["features"]) == 4
    assert not set(first) & set(others["features"])
    rows, error = named(*first), session.suggest(Rows())["error_95_mm"]
    for _ in range(6):
        found = session.suggest(rows)
        assert found["error_95_mm"] <= error
        assert bool(found["features"]) == (found["error_95_mm"] < error)
        rows, error = Rows(rows.columns, (*rows.cells, *named(*found["features"]).cells)), found["error_95_mm"]


def test_nothing_is_suggested_for_touches_or_unknown_features(part: PickPart) -> None:
    session, touches = opened(part, "touches_321.csv")
    with pytest.raises(InputError, match="without a column kind"):
        session.suggest(touches)
    with pytest.raises(InputError, match="no feature 'V99'"):
        session.suggest(named("V99"))


def test_points_are_suggested_for_bodies_that_may_have_moved(part: PickPart) -> None:
    """A plate without a touch comes first; touches on faces count as well as features."""
    session = PickSession(part)
    session.choose(MovingChoice(is_on=True, tack_mm=2.0))
    assert len(session.suggest(Rows())["features"]) == 4
    on_base = named("V1", "V3", "V13", "H1")
    found = session.suggest(on_base)
    (touch,) = found["touches"]
    assert found["features"] == [touch["name"]]
    assert touch["body"] == "web"
    assert f"seam {touch['seam']} from {touch['before_mm']:.2f} mm to {touch['after_mm']:.2f} mm" in touch["sentence"]
    touches = session.read((TEE / "touches_321.csv").read_bytes(), name="touches_321.csv")[0]
    (on_faces,) = session.suggest(touches)["touches"]
    assert on_faces["body"] == "web"  # the six touches of the table are on the base


def test_a_row_touched_on_the_neighbour_of_its_feature_comes_with_that_feature(part: PickPart) -> None:
    session = PickSession(part)
    table = (TEE / "taught_exact.csv").read_text().splitlines()
    exact = session.read("\n".join(table).encode(), name="exact.csv")[0]
    places = {f.name: f.p_mm for f in part.workpiece.features if f.kind.is_point}
    T = session.fit(exact)["T_base_part"]
    names = [line.split(",")[0] for line in table[1:]]
    wrong, near = (
        names[0],
        min(
            (name for name in places if name[0] == "V" and name not in names),
            key=lambda name: float(np.linalg.norm(places[name] - places[names[0]])),
        ),
    )
    x, y, z = np.array(T)[:3, :3] @ places[near] + np.array(T)[:3, 3]
    cells = table[1].split(",")
    cells[1:4] = [f"{x:.3f}", f"{y:.3f}", f"{z:.3f}"]
    slipped = session.read("\n".join([table[0], ",".join(cells), *table[2:]]).encode(), name="slip.csv")[0]
    found = session.fit(slipped)["exchanges"]
    assert [(one["row"], one["feature"]) for one in found] == [(0, near)]
    assert wrong != near

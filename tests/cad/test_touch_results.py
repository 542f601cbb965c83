"""Results of touch programs: read from the files of every controller, paired, checked, fitted."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.workpiece.fit_taught import prepare_fit
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.coverage_study import error_95
from tests.few import few
from tests.record_checks import check_record
from tests.robot_servers import PASSWORD, USER, Robot, fake_tls
from tests.running import FINISHED, run_here
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.touch_results_files import DIGITS_MM, WRITERS
from wpcal.brep.surfaces import project_to_faces
from wpcal.calibrate import CalibrationResult, Criterion, TeachingError, Touches, calibrate
from wpcal.calibrate.errors.of_touches import budget_of_touches
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.solve.touches import Pose, fit_squares
from wpcal.controllers.registry import controllers
from wpcal.controllers.touch_run import read_touch_results
from wpcal.core import FormatError, InputError, RigidTransform
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation
from wpcal.touch.searches import Contact, Outcome, Search, SearchKind, TouchPlan, TouchSetup
from wpcal.touch.touch_results import TOUCH_LEFT_OUT, nominal_place, pair_results

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
pytestmark = pytest.mark.usefixtures("kernel_here")
PLAN = tee_plan()
MOVED = RigidTransform(exp_rotation([0.004, -0.003, 0.006]), np.array([1.2, -0.9, 0.8]), "part", "part")
"""Where the real part stands, seen from where it was planned."""
LEVER = 5.0  #: Places are this much surer than the pose far from them, at most.


@pytest.fixture(scope="module")
def tee() -> Workpiece:
    return open_workpiece(TEE / "tee.step")


def touched(tee: Workpiece, search: Search, moved: RigidTransform = MOVED) -> FloatArray:
    """Follow a search to the place where the wire meets the moved part, in `part` as planned."""
    plan = replace(PLAN, searches=(search,))
    nowhere = {search.name: search.planned}
    taught = pair_results(plan, _results(plan, nowhere)).taught
    targets = prepare_fit(taught, tee, T_nominal_part=nominal_place(PLAN)).fitted
    assert isinstance(targets, Touches)
    face = targets.targets.index[0]  # type: ignore[attr-defined]

    def gap(t: float) -> float:
        x = moved.inverse().apply((search.start + t * search.direction)[None])
        foot = project_to_faces(tee.graph, np.array([face]), x)
        return float(((x - foot.p) * foot.normal).sum()) - search.radius_mm

    low, high = 0.0, search.stroke_mm
    assert gap(low) > 0 > gap(high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gap(middle) > 0 else (low, middle)
    return np.asarray(search.start + low * search.direction)


def _results(plan: TouchPlan, stored: dict):  # type: ignore[type-arg, no-untyped-def]
    from wpcal.controllers.abb.touch import read_rapid_results as read
    from wpcal.touch.searches import ResultsFile

    return read([ResultsFile(name, text) for name, text in WRITERS["rapid"](plan, stored).items()], plan, TouchSetup())


@pytest.fixture(scope="module")
def exact(tee: Workpiece) -> dict[str, FloatArray]:
    return {search.name: touched(tee, search) for search in PLAN.searches}


def written(folder: Path, brand: str, stored: dict, plan: TouchPlan = PLAN) -> Path:  # type: ignore[type-arg]
    folder.mkdir(exist_ok=True)
    for name, text in WRITERS[brand](plan, stored).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / next(iter(WRITERS[brand](plan, stored)))


def test_every_controller_that_writes_touches_reads_their_results() -> None:
    writing = {each.name for each in controllers() if each.touch_writer is not None}
    assert writing == {each.name for each in controllers() if each.touch_results_reader is not None} == set(WRITERS)


@pytest.mark.parametrize("brand", few(WRITERS, 2))
def test_results_without_noise_give_the_pose_to_the_stored_digits(
    tee: Workpiece, exact: dict[str, FloatArray], brand: str, tmp_path: Path, golden: Any
) -> None:
    results = read_touch_results(written(tmp_path, brand, exact), PLAN)
    assert (results.controller, results.fingerprint, results.count) == (brand, PLAN.fingerprint, 8)
    observed = prepare_fit(pair_results(PLAN, results).taught, tee, T_nominal_part=nominal_place(PLAN))
    found = calibrate(observed.fitted, criterion=Criterion.WEIGHTED, T_nominal_part=nominal_place(PLAN))
    truth = PLAN.T_base_part @ MOVED
    corners = np.array([[0, 0, 0], [200, 0, 0], [0, 120, 0], [200, 120, 90.0]])
    apart = np.linalg.norm(found.T_base_part.apply(corners) - truth.apply(corners), axis=1).max()
    assert apart <= LEVER * DIGITS_MM[brand]
    golden(results)


@pytest.mark.parametrize("brand", WRITERS)
def test_missed_and_skipped_searches_are_told_and_left_out(
    exact: dict[str, FloatArray], brand: str, tmp_path: Path, golden: Any
) -> None:
    stored = {**exact, "T2": Outcome.MISSED, "T5": Outcome.NOT_RUN, "T7": Outcome.ACTIVE_AT_START}
    paired = pair_results(PLAN, read_touch_results(written(tmp_path, brand, stored), PLAN))
    assert paired.taught.names == ("T1", "T3", "T4", "T6", "T8")
    assert paired.left_out == (("T2", Outcome.MISSED), ("T5", Outcome.NOT_RUN), ("T7", Outcome.ACTIVE_AT_START))
    (issue,) = paired.issues
    assert issue.code == TOUCH_LEFT_OUT
    assert "T2 missed" in issue.message
    assert "T7 was not made" in issue.message
    golden(paired)


@pytest.mark.parametrize("brand", WRITERS)
def test_results_of_another_plan_are_one_line(exact: dict[str, FloatArray], brand: str, tmp_path: Path) -> None:
    path = written(tmp_path, brand, exact, replace(PLAN, stick_out_mm=16.0))
    with pytest.raises(FormatError, match="holds results of the plan"):
        pair_results(PLAN, read_touch_results(path, PLAN))


def test_a_place_outside_its_stroke_is_refused_with_its_name(exact: dict[str, FloatArray]) -> None:
    t4, t6 = PLAN.search("T4"), PLAN.search("T6")
    for stored, words in (
        ({"T4": exact["T4"] + np.array([20.0, 0, 0])}, "T4 is 20 mm beside it"),
        ({"T4": t4.start - 20.0 * t4.direction}, "T4 is 20 mm before its start"),
        ({"T6": t6.end + 9.0 * t6.direction}, "T6 is 9 mm behind its end"),
    ):
        with pytest.raises(FormatError, match=words):
            pair_results(PLAN, _results(PLAN, {**exact, **stored}))


def test_a_wrong_frame_or_tool_is_one_line(exact: dict[str, FloatArray]) -> None:
    good = _results(PLAN, exact)
    assert good.T_base_part is not None
    shifted = RigidTransform(good.T_base_part.R, good.T_base_part.t_mm + np.array([0, 20.0, 0]), "base", "frame")
    with pytest.raises(FormatError, match=r"20\.00 mm and 0\.00 degrees from the place of the part"):
        pair_results(PLAN, replace(good, T_base_part=shifted))
    turned = tuple(replace(each, R=each.R @ exp_rotation([0.2, 0, 0])) for each in good.results)
    with pytest.raises(FormatError, match="another tool or frame was active"):
        pair_results(PLAN, replace(good, results=turned))
    with pytest.raises(FormatError, match="holds 7 searches, and the plan has 8; they differ in T8"):
        pair_results(PLAN, replace(good, results=good.results[:-1], count=None))
    none = tuple(replace(each, outcome=Outcome.NOT_RUN, p=None) for each in good.results)
    with pytest.raises(FormatError, match="none of its searches was run"):
        pair_results(PLAN, replace(good, results=none))


def test_latency_is_taken_back_along_the_direction(exact: dict[str, FloatArray], golden: Any) -> None:
    setup = TouchSetup(latency_s=0.02, search_speed_mm_s=10.0)
    late = {name: p + 0.2 * PLAN.search(name).direction for name, p in exact.items()}
    one, other = (pair_results(PLAN, _results(PLAN, exact)), pair_results(PLAN, _results(PLAN, late), setup))
    np.testing.assert_allclose(other.taught.p_base, one.taught.p_base, rtol=0, atol=1e-5)
    golden(one)


def test_a_post_solves_the_stick_out(exact: dict[str, FloatArray]) -> None:
    longer = 0.7
    at = np.array([700.0, -300.0, 100.0])
    up = np.array([0.0, 0.0, 1.0])
    R_base_tool = np.diag([1.0, -1.0, -1.0])
    post = replace(
        PLAN.searches[0],
        name="POST",
        contact_part=at,
        normal_part=up,
        contact=Contact.END,
        radius_mm=0.0,
        R_part_tool=PLAN.T_base_part.R.T @ R_base_tool,
        start=at + 8 * up,
        end=at - 8 * up,
        kind=SearchKind.POST,
    )
    plan = replace(PLAN, searches=(post, *PLAN.searches))
    wires = {s.name: s.R_part_tool[:, 2] if s.contact is Contact.END else 0.0 * up for s in PLAN.searches}
    stored = {name: p - longer * wires[name] for name, p in exact.items()}
    stored["POST"] = PLAN.T_base_part.inverse().apply((at + longer * up)[None])[0]
    paired = pair_results(plan, _results(plan, stored))
    assert paired.stick_out_mm == pytest.approx(longer, rel=0, abs=1e-5)
    ends = [row for row, s in enumerate(PLAN.searches) if s.contact is Contact.END]
    plain = pair_results(PLAN, _results(PLAN, exact)).taught
    np.testing.assert_allclose(paired.taught.p_base[ends], plain.p_base[ends], rtol=0, atol=1e-4)
    assert paired.taught.covariances is not None
    assert plain.covariances is not None
    assert (np.trace(paired.taught.covariances, axis1=1, axis2=2) < np.trace(plain.covariances, axis1=1, axis2=2)).all()


SHIFTS = ((0, -70, 0), (0, -60, 0), (60, 0, 0), (50, 0, 0), (-50, 0, 0), (0, 35, 0), (0, 0, 20))
"""From the first seven searches to seven more on the same faces."""


def twice_touched() -> TouchPlan:
    more = [
        replace(s, name=f"{s.name}b", contact_part=s.contact_part + d, start=s.start + d, end=s.end + d)
        for s, d in zip(PLAN.searches, SHIFTS, strict=False)
    ]
    return replace(PLAN, searches=(*PLAN.searches, *more))


def calibrated(tee: Workpiece, plan: TouchPlan, stored: dict) -> CalibrationResult:  # type: ignore[type-arg]
    paired, at = pair_results(plan, _results(plan, stored)), nominal_place(plan)
    own = prepare_fit(paired.taught, tee, T_nominal_part=at, silent=paired.silent)
    return calibrate(own.fitted, criterion=Criterion.WEIGHTED, T_nominal_part=at, tolerance_mm=1.5, silent=own.silent)


@pytest.mark.parametrize("missed", few([True, False], 1))
def test_a_missed_search_shows_that_the_part_is_turned(tee: Workpiece, missed: bool) -> None:
    """Turned by 180 degrees the tee has the same faces but for its hole: only the search in it finds nothing."""
    plan = twice_touched()
    stored = {s.name: touched(tee, s, MOVED) for s in plan.searches}
    found = calibrated(tee, plan, {**stored, "T8": Outcome.MISSED} if missed else stored)
    assert found.verdict == ("UNSURE" if missed else "PASS")
    assert ("silent-search" in [issue.code for issue in found.issues]) is missed


def test_a_search_that_rightly_found_nothing_is_no_evidence(tee: Workpiece) -> None:
    plan = twice_touched()
    away = RigidTransform(np.eye(3), np.array([7.0, 0.0, 0.0]), "part", "part")  # the hole is 7 mm beside its search
    stored = {s.name: touched(tee, s, away) for s in plan.searches if s.name != "T8"}
    assert calibrated(tee, plan, {**stored, "T8": Outcome.MISSED}).verdict == "PASS"


def test_touches_of_another_face_are_no_pass(tee: Workpiece, exact: dict[str, FloatArray]) -> None:
    plan = twice_touched()
    stored = {s.name: touched(tee, s) for s in plan.searches}
    for name in ("T6", "T6b"):  # a clamp before the face
        stored[name] = stored[name] - 5.0 * plan.search(name).direction
    assert calibrated(tee, plan, stored).verdict == "FAIL"


def test_the_planned_normal_decides_between_two_faces_of_an_edge(tee: Workpiece, exact: dict[str, FloatArray]) -> None:
    """The side of the wire may touch 0.2 mm below the border of its face."""
    low = np.array([0.0, 0.0, 4.8])
    near = replace(PLAN.search("T6"), contact_part=PLAN.search("T6").contact_part + low)
    plan = replace(PLAN, searches=tuple(near if s.name == "T6" else s for s in PLAN.searches))
    taught = pair_results(plan, _results(plan, exact)).taught
    observed = prepare_fit(taught, tee, T_nominal_part=nominal_place(plan)).fitted
    assert isinstance(observed, Touches)
    normals = observed.targets.nearest(observed.rows, taught.p_part).normal
    np.testing.assert_allclose(normals[5], near.normal_part, rtol=0, atol=1e-9)
    with pytest.raises(FormatError, match="equally near to two faces"):
        prepare_fit(replace(taught, normal_part=None), tee, T_nominal_part=nominal_place(plan))


def test_what_is_no_results_file_is_one_line(exact: dict[str, FloatArray], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected"):
        read_touch_results(Path("touches.csv"), PLAN)
    posreg = written(tmp_path / "fanuc", "fanuc", exact)
    (posreg.parent / "numreg.va").unlink()
    with pytest.raises(FormatError, match=r"without numreg\.va"):
        read_touch_results(posreg, PLAN)
    program = tmp_path / "other.mod"
    program.write_text("MODULE other\nENDMODULE\n", encoding="utf-8")
    with pytest.raises(FormatError, match="holds no results of a touch program"):
        read_touch_results(program, PLAN)
    both = tmp_path / "both"
    written(both, "krl", exact)
    written(both, "rapid", exact)
    with pytest.raises(InputError, match="holds files of krl, rapid"):
        read_touch_results(both, PLAN)


def test_asterisks_and_empty_registers_are_told_by_name(exact: dict[str, FloatArray], tmp_path: Path) -> None:
    path = written(tmp_path, "fanuc", exact)
    text = path.read_text()
    path.write_text(text.replace(text.split("[1,53]")[1].split("X:")[1][:10], " ********", 1))
    with pytest.raises(FormatError, match=r"search T2: its place PR\[53\] has coordinates .* asterisks"):
        read_touch_results(path, PLAN)
    path.write_text(text.replace("[1,54] =   'touch' ", "[1,54] =   '' Uninitialized", 1))
    with pytest.raises(FormatError, match=r"search T3: its place PR\[54\] is not initialised"):
        read_touch_results(path, PLAN)


def test_the_command_fits_results_and_says_which_searches_it_used(exact: dict[str, FloatArray], tmp_path: Path) -> None:
    stored = {**exact, "T2": Outcome.MISSED}
    written(tmp_path / "results", "krl", stored)
    out = tmp_path / "out"
    plan = TEE_PLAN / "touches.json"
    done = run_here("calibrate", TEE / "tee.step", tmp_path / "results", "--touches", plan, "-o", out)
    assert "T2 missed" in done.stdout
    record = json.loads((out / "calibration.json").read_text())
    check_record(record)
    assert record["searches"]["used"] == ["T1", "T3", "T4", "T5", "T6", "T7", "T8"]
    assert record["searches"]["left_out"] == [{"name": "T2", "outcome": "missed"}]
    assert record["criterion"] == "weighted"
    t = np.array(record["T_base_part"])[:3, 3]
    np.testing.assert_allclose(t, (PLAN.T_base_part @ MOVED).t_mm, rtol=0, atol=1e-3)


FROM = [("kuka", "krl"), ("fanuc", "fanuc"), ("abb", "rapid"), ("omnicore", "rapid")]
FROM += [("fanuc-ftp", "fanuc"), ("ur", "urscript")]
"""The client of each link reads its server in `tests/unit/links` in every run."""


@pytest.mark.parametrize(("kind", "brand"), few(FROM, 1))
def test_results_read_from_the_robot_are_those_of_its_files(
    exact: dict[str, FloatArray], kind: str, brand: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WPCAL_LINK_USER", USER)
    monkeypatch.setenv("WPCAL_LINK_PASSWORD", PASSWORD)
    written_here = written(tmp_path / "files", brand, exact).parent
    files = {each.name.lower(): each.read_bytes() for each in written_here.iterdir()}
    plan = written(tmp_path / "plan", brand, dict.fromkeys(exact, Outcome.NOT_RUN)).with_name("touches.json")
    plan.write_bytes((TEE_PLAN / "touches.json").read_bytes())
    served = {"omnicore": "abb", "ur": "ur-log"}.get(kind, kind)
    robot = Robot(files=files)
    with robot.serve(served, fake_tls() if kind == "omnicore" else None) as port:
        words = (TEE / "tee.step", "--touches", plan, "--from", f"{kind}:127.0.0.1:{port}")
        done = run_here("calibrate", *words, tmp_path / "read", "-o", tmp_path / "out")
        again = run_here("calibrate", *words, tmp_path / "read", "-o", tmp_path / "again")
        robot.files = {name: data.replace(PLAN.fingerprint.encode(), b"01234567") for name, data in files.items()}
        other_plan = run_here("calibrate", *words, tmp_path / "other", "-o", tmp_path / "wrong")
    assert done.returncode in FINISHED, done.stderr
    assert again.returncode in FINISHED
    if kind not in ("kuka", "ur"):  # these have no files: what is read is put into one
        assert {each.name: each.read_bytes() for each in (tmp_path / "read").iterdir()} == files
    if brand != "fanuc":
        assert (other_plan.returncode, "holds results of the plan" in other_plan.stderr) == (2, True)
    run_here("calibrate", TEE / "tee.step", written_here, "--touches", plan, "-o", tmp_path / "from_files")
    one, other = (json.loads((tmp_path / name / "calibration.json").read_text()) for name in ("out", "from_files"))
    assert one["T_base_part"] == other["T_base_part"]
    assert one["searches"]["used"] == other["searches"]["used"] == [each.name for each in PLAN.searches]
    assert PASSWORD not in (tmp_path / "out" / "job.json").read_text() + done.stdout + done.stderr


@pytest.mark.parametrize("criterion", few([Criterion.WEIGHTED, Criterion.LEAST_SQUARES], 0))
def test_errors_that_all_touches_share_are_in_the_predicted_error(
    tee: Workpiece, exact: dict[str, FloatArray], criterion: Criterion
) -> None:
    """Three touches see the same wrong stick-out: its error does not become smaller with their number."""
    taught = pair_results(PLAN, _results(PLAN, exact)).taught
    touches = prepare_fit(taught, tee, T_nominal_part=nominal_place(PLAN)).fitted
    assert isinstance(touches, Touches)
    assert touches.covariances is not None
    truth, rng, covered = PLAN.T_base_part @ MOVED, np.random.default_rng(0), []
    start = Pose.of(touches, truth.R, truth.t_mm)
    covariance = budget_of_touches(touches, start, criterion, TeachingError(robot=RobotField.none())).covariance
    seam = truth.apply(np.array([[25.0, 60, 10], [100, 60, 10], [175, 60, 10]]))
    predicted = error_95(seam, covariance)
    own = np.linalg.cholesky(touches.covariances - touches.shared @ touches.shared.swapaxes(1, 2))
    for _ in range(400):
        off = np.einsum("nij,nj->ni", own, rng.normal(size=(len(touches), 3))) + touches.shared @ rng.normal(size=2)
        noisy = replace(touches, p_base=touches.p_base + off)
        pose = fit_squares(noisy, start, weighted=criterion is Criterion.WEIGHTED)
        moved = (seam - truth.t_mm) @ truth.R @ pose.R.T + pose.t
        covered.append(np.linalg.norm(moved - seam, axis=1) <= predicted)
    assert 0.92 <= np.mean(covered) <= 0.98

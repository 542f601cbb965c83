"""The hostile user: every wrong input is one line on stderr and exit code 2, and nothing is written."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.few import few
from tests.running import needs_proc, run_here, run_process

ROOT = Path(__file__).parents[2]
TEE = ROOT / "fixtures" / "tee"
SHARED = ROOT.parent / "shared" / "step"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a part and its taught points, in which the commands run."""
    for name in ("tee.step", "taught.csv"):
        shutil.copy(TEE / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def assert_refused(folder: Path, *arguments: Path | str, says: str) -> None:
    before = sorted(folder.rglob("*"))
    ended = run_here(*arguments)
    assert (ended.returncode, ended.stdout) == (2, ""), ended.stderr
    assert ended.stderr.startswith("wpcal: ")
    assert ended.stderr.count("\n") == 1
    assert says in ended.stderr
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "command",
    few(
        [
            (("features", "none.step"),),
            (("calibrate", "none.step", "taught.csv", "-o", "out"),),
            (("seams", "none.step"),),
            (("advise", "none.step"),),
            (("match", "none.step", "taught.csv"),),
            (("pick", "none.step", "--no-browser", "-o", "new.csv"),),
            (("sheet", "none.step", "-o", "sheet.svg"),),
        ],
        1,
    ),
    ids=lambda command: command[0],
)
def test_a_process_ends_with_code_2_and_one_line_on_its_error_stream(folder: Path, command: tuple[str, ...]) -> None:
    before = sorted(folder.rglob("*"))
    done = run_process(*command, cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "wpcal: none.step: no such file or directory\n"
    assert sorted(folder.rglob("*")) == before


def empty(path: Path) -> None:
    path.write_bytes(b"")


def pdf(path: Path) -> None:
    path.write_bytes(b"%PDF-1.7\n" + bytes(range(200)))


def pointer(path: Path) -> None:
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n")


def directory(path: Path) -> None:
    path.unlink()
    path.mkdir()


def missing(path: Path) -> None:
    path.unlink()


def without_solid(path: Path) -> None:
    text = path.read_text()
    head, data = text.split("DATA;", 1)
    path.write_text(f"{head}DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n")
    assert data


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (missing, "no such file"),
        (directory, "is a folder"),
        (empty, "is empty"),
        (pdf, "is a PDF"),
        (pointer, "Git LFS pointer"),
        (without_solid, "tee.step"),
    ],
)
@pytest.mark.parametrize(
    "command", few([(("calibrate", "taught.csv", "-o", "out"),), (("features",),), (("seams",),)], 1)
)
def test_a_part_that_cannot_be_read(
    folder: Path, spoil: Callable[[Path], None], says: str, command: tuple[str, ...]
) -> None:
    spoil(folder / "tee.step")
    assert_refused(folder, command[0], "tee.step", *command[1:], says=says)


@pytest.mark.parametrize("spoil", [missing, directory, empty, pdf, pointer])
def test_a_file_that_is_not_step_is_refused_before_the_kernel_loads(
    folder: Path, spoil: Callable[[Path], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def start_no_child(*_: object, **__: object) -> None:
        raise AssertionError("the child process was started")

    monkeypatch.setattr("subprocess.Popen", start_no_child)
    spoil(folder / "tee.step")
    assert_refused(folder, "features", "tee.step", says="tee.step")


def rows(path: Path) -> list[str]:
    return path.read_text().splitlines()


def not_a_number(path: Path) -> None:
    lines = rows(path)
    lines[2] = "V4,nan,1,2,yes"
    path.write_text("\n".join(lines))


def metres(path: Path) -> None:
    head, *body = rows(path)
    cells = [line.split(",") for line in body]
    path.write_text(
        "\n".join([head, *(f"{c[0]},{','.join(str(float(v) / 1000) for v in c[1:4])},{c[4]}" for c in cells)])
    )


def collinear(path: Path) -> None:
    header = "name,x_mm,y_mm,z_mm,model_x_mm,model_y_mm,model_z_mm"
    path.write_text("\n".join([header, *(f"p{i},{i}00,0,0,{i}00,0,0" for i in range(4))]))


def as_step(path: Path) -> None:
    shutil.copy(TEE / "tee.step", path)


def misspelt(path: Path) -> None:
    path.write_text(path.read_text().replace("use", "used"))


def half_a_model(path: Path) -> None:
    path.write_text(path.read_text().replace("use", "model_x_mm").replace("yes", "1").replace("check", "2"))


def out_of_this_world(path: Path) -> None:
    path.write_text(path.read_text().replace("812.29", "1e300"))


def inches(path: Path) -> None:
    path.write_text("\n".join([rows(path)[0], *(f"{name},{point}" for name, point in INCHES.items())]))


INCHES = {"V2": "0,0,0,yes", "V4": "0,4.7244,0,yes", "V16": "7.874,4.7244,0,yes", "V12": "6.8898,2.5197,3.1496,yes"}
"""The tee's corners in its own coordinates, in inches."""


def coinciding(path: Path) -> None:
    path.write_text("\n".join([rows(path)[0], *(f"{name},1,2,3,yes" for name in INCHES)]))


def only_checks(path: Path) -> None:
    path.write_text(path.read_text().replace("yes", "check"))


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (missing, "taught.csv: no such file"),
        (directory, "taught.csv: is a folder"),
        (as_step, "taught.csv: is a STEP file"),
        (misspelt, "unknown column 'used'; did you mean use?"),
        (half_a_model, "missing column model_y_mm, model_z_mm"),
        (out_of_this_world, "taught.csv, line 2, column x_mm: expected a number of at most 1e+09"),
        (inches, "taught.csv: the distances between the taught points are 0.0393"),
        (coinciding, "coincide"),
        (only_checks, "at least 3 points with use yes, got 0"),
        (empty, "taught.csv: the file is empty"),
        (not_a_number, "line 3, column x_mm"),
        (metres, "look like metres"),
        (collinear, "on one line"),
    ],
)
@pytest.mark.usefixtures("kernel_here")
def test_taught_points_that_cannot_be_used(folder: Path, spoil: Callable[[Path], None], says: str) -> None:
    spoil(folder / "taught.csv")
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", "out", says=says)


@pytest.mark.parametrize(
    ("option", "says"),
    [
        (("--chord-mm", "0"), "chord_mm must be positive"),
        (("--min-step-mm", "20"), "min_step_mm"),
        (("--sigma-mm", "-1"), "sigma_mm"),
        (("--tolerance-mm", "-1"), "tolerance"),
        (("--nominal", "taught.csv"), "--nominal: taught.csv: is not JSON"),
        (("--max-step-mm", "nan"), "--max-step-mm"),
        (("--gap-mm", "-1"), "--gap-mm"),
        (("--nominal", "somewhere"), "--nominal"),
        (("--nominal", "1,2,3,4,5,nan"), "finite"),
        (("--criterion", "best"), "criterion"),
        (("--seed", "-1"), "seed"),
    ],
)
@pytest.mark.usefixtures("kernel_here")
def test_options_without_meaning(folder: Path, option: tuple[str, str], says: str) -> None:
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", "out", *option, says=says)


@pytest.mark.usefixtures("kernel_here")
def test_a_nominal_pose_that_is_not_a_matrix(folder: Path) -> None:
    (folder / "pose.json").write_text('{"T_base_part": 1}')
    command = ("calibrate", "tee.step", "taught.csv", "-o", "out", "--nominal", "pose.json")
    assert_refused(folder, *command, says="--nominal: pose.json: expected a 4×4 matrix")


@pytest.mark.usefixtures("kernel_here")
def test_an_output_folder_that_holds_something(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out" / "mine.txt").write_text("keep")
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", "out", says="--force")
    done = run_here("calibrate", "tee.step", "taught.csv", "-o", "out", "--force")
    assert done.returncode == 0, done.stderr
    assert (folder / "out" / "mine.txt").read_text() == "keep"


@pytest.mark.parametrize(("output", "says"), [("tee.step", "is a file"), ("taught.csv/out", "cannot be written")])
@pytest.mark.usefixtures("kernel_here")
def test_an_output_that_is_a_file_or_below_one(folder: Path, output: str, says: str) -> None:
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", output, says=says)


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes into a folder that nobody may write to")
def test_a_folder_that_nobody_may_write_to(folder: Path) -> None:
    (folder / "mine").mkdir(mode=0o555)
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", "mine/out", says="permission denied")


@needs_proc
def test_a_disk_that_cannot_be_written(folder: Path) -> None:
    assert_refused(folder, "calibrate", "tee.step", "taught.csv", "-o", "/proc/out", says="cannot be written")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_leaves_no_half_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from wpcal.core.errors import InputError
    from wpcal.core.records import new_directory

    def write() -> None:
        with new_directory(folder / "out", overwrite=False) as place:
            (place / "first.json").write_text("{}")
            Path("/dev/full").write_text("x" * 100_000)

    with pytest.raises(InputError, match="no space left"):
        write()
    assert sorted(path.name for path in folder.iterdir()) == ["taught.csv", "tee.step"]


def test_json_on_stdout_is_the_file(folder: Path) -> None:
    done = run_process("calibrate", "tee.step", "taught.csv", "-o", "out", "--json", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == (folder / "out" / "calibration.json").read_text()


@pytest.mark.usefixtures("kernel_here")
def test_names_that_look_like_markup_are_printed(folder: Path) -> None:
    part = folder / "tee.step"
    part.write_text(part.read_text().replace("'web'", "'web[/b]'"))
    done = run_here("seams", "tee.step")
    assert (done.returncode, done.stderr) == (0, "")
    assert "web[/b]" in done.stdout


@pytest.mark.deep
def test_a_terminal_without_greek_letters(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    done = run_process("calibrate", "tee.step", "taught.csv", "-o", "out", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert "PASS" in done.stdout


@pytest.mark.parametrize("name", ["odd_lfs_pointer.stp", "odd_truncated_nist_ctc_01.stp", "s1-c5-214.stp"])
def test_odd_files_of_others(folder: Path, name: str) -> None:
    if not (SHARED / name).is_file():
        pytest.skip("the shared STEP files are not beside the project")
    assert_refused(folder, "features", SHARED / name, says=name)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("-o", "sheet.svg", "--touch", "V99"), "the part has no feature 'V99'"),
        (("-o", "sheet.svg", "--touch", "V2,v2"), "named twice"),
        (("-o", "sheet.svg", "--touch", "2"), "at least 3 points"),
        (("-o", "sheet.svg", "--touch", ","), "expected a number or names"),
        (("taught.csv", "-o", "sheet.svg", "--touch", "4"), "either TAUGHT.csv or --touch"),
        (("none.csv", "-o", "sheet.svg"), "none.csv"),
        (("-o", "nowhere/sheet.svg", "--touch", "V2"), "nowhere/sheet.svg: cannot be written"),
        (("-o", "taught.csv/sheet.svg", "--touch", "V2"), "cannot be written"),
    ],
)
@pytest.mark.usefixtures("kernel_here")
def test_a_sheet_that_cannot_be_drawn(folder: Path, options: tuple[str, ...], says: str) -> None:
    assert_refused(folder, "sheet", "tee.step", *options, says=says)


@pytest.mark.usefixtures("kernel_here")
def test_a_sheet_is_not_overwritten_without_force(folder: Path) -> None:
    (folder / "sheet.svg").write_text("mine")
    assert_refused(folder, "sheet", "tee.step", "-o", "sheet.svg", says="--force")
    (folder / "advised.csv").write_text(
        "name,x_mm,y_mm,z_mm,use,where\nV4,,,,yes,here\nH1,,,,no,\nV16,,,,check,\nV2,,,,,\n"
    )
    done = run_here("sheet", "tee.step", "advised.csv", "-o", "sheet.svg", "--force", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert [point["name"] for point in json.loads(done.stdout)["points"]] == ["V4", "V16", "V2"]
    assert (folder / "sheet.svg").read_text().startswith("<?xml")

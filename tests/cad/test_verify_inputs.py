"""`wpcal verify` and everything that results depend on: files that other files name, decisions, scripts, other places.

The files are written here; which of them count is known before wpcal reads them.
"""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from cad.samples.parts import SAMPLE_INPUTS
from cad.workpiece.calibrate import calibrate_files
from tests.record_checks import check_record
from tests.running import kernel_work_here, run_here
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.touch_results_files import WRITERS
from wpcal.robot.kinematics.arm_file import shipped_arms

ROOT = Path(__file__).parents[2]
TEE = ROOT / "fixtures" / "tee"
CELL = ROOT / "fixtures" / "cells" / "two-mh6.json"
HELD = ("--cell", "cells/cell.json", "--holder-joints", "0,0,0,0,-60,0")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Commands run here, in this process; `home` holds the inputs, and each test writes its own results."""
    folder = tmp_path_factory.mktemp("inputs")
    home = folder / "home"
    (home / "cells" / "arms").mkdir(parents=True)
    for name in ("tee.step", "taught.csv"):
        shutil.copy(TEE / name, home)
    cell = json.loads(CELL.read_text())
    cell["torch_robot"]["arm"] = "arms/mine.json"
    (home / "cells" / "cell.json").write_text(json.dumps(cell))
    shutil.copy(ROOT / "wpcal" / "robot" / "arms" / "mh6.json", home / "cells" / "arms" / "mine.json")
    (home / "plan").mkdir()
    shutil.copy(TEE_PLAN / "touches.json", home / "plan")
    plan = tee_plan()
    for name, text in WRITERS["fanuc"](plan, {each.name: each.planned for each in plan.searches}).items():
        (home / name).write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        patch.setattr("cad.work.child.run_in_child", kernel_work_here)
        yield folder


def files_of(out: Path) -> list[str]:
    record = json.loads((out / "job.json").read_text())
    check_record(record)
    return [each["file"] for each in record["inputs"]["files"]]


def verified(*words: Path | str) -> tuple[int, str]:
    done = run_here("verify", *words)
    return done.returncode, done.stdout


def test_a_file_that_a_file_of_an_option_names_counts(folder: Path) -> None:
    assert "mh6" in shipped_arms()
    assert run_here("calibrate", "tee.step", "taught.csv", "-o", "held", *HELD).returncode == 0
    out = Path("held")
    assert files_of(out) == ["cells/cell.json", "cells/arms/mine.json"]
    assert verified(out) == (0, "held: as claimed\n")
    elsewhere = folder / "elsewhere"
    shutil.copytree(out, elsewhere / "held")
    shutil.copytree(folder / "home" / "cells", elsewhere / "robots")
    given = [elsewhere / "robots", TEE / "tee.step", TEE]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(elsewhere)
        assert verified("held")[0] == 2
        assert verified("held", *(word for place in given for word in ("--inputs", place)))[0] == 0
        arm = elsewhere / "robots" / "arms" / "mine.json"
        arm.write_text(arm.read_text() + "\n")
        code, text = verified("held", *(word for place in given for word in ("--inputs", place)))
        assert code == 2
        assert "mine.json: is not the file of which the results were made" in text
    record = json.loads((out / "job.json").read_text())
    del record["inputs"]["files"][1]
    (out / "job.json").write_text(json.dumps(record))
    assert verified(out)[0] != 0


@pytest.mark.deep
@pytest.mark.usefixtures("folder")
def test_both_files_of_a_run_of_touches_and_its_plan_in_a_folder_count() -> None:
    done = run_here("calibrate", "tee.step", "posreg.va", "--touches", "plan", "-o", "touched")
    assert done.returncode in {0, 1}, done.stderr
    assert files_of(Path("touched")) == ["plan/touches.json", "numreg.va"]
    assert verified("touched") == (0, "touched: as claimed\n")
    before = Path("numreg.va").read_text()
    Path("numreg.va").write_text(before + "\n")
    code, text = verified("touched")
    Path("numreg.va").write_text(before)
    assert (code, "numreg.va: is not the file" in text) == (2, True)


@pytest.mark.deep
def test_a_demo_is_checked_in_any_place_and_a_script_leaves_no_request_of_another(folder: Path) -> None:
    assert "mm at V6 (check)" in " ".join(run_here("demo", "-o", "demo").stdout.split())
    shutil.move("demo", folder / "kept")
    demo = folder / "kept"
    assert verified(demo)[0] == 0
    part, taught = (demo / name for name in SAMPLE_INPUTS)
    calibrate_files(part, taught, demo, overwrite=True)
    assert not (demo / "job.json").exists()
    assert verified(demo)[0] == 0  # the usual options give the same
    for name in SAMPLE_INPUTS:
        (demo / name).unlink()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(demo)  # the home has the same files
        code, text = verified(demo)
        assert (code, "Its files agree with one another" in text) == (2, True)
        table = demo / "seams.csv"
        table.write_text(table.read_text().replace("1", "2", 1))
        code, text = verified(demo)
        assert (code, "seams.csv line" in text) == (1, True)


@pytest.mark.deep
@pytest.mark.usefixtures("folder")
def test_files_of_others_in_the_folder_are_named_as_not_checked() -> None:
    assert run_here("calibrate", "tee.step", "taught.csv", "-o", "mixed").returncode == 0
    Path("mixed/weld.mod").write_text("MODULE weld\nENDMODULE\n")
    done = run_here("verify", "mixed", "--json")
    (checked,) = json.loads(done.stdout)["checked"]
    assert (done.returncode, checked["unchecked"]) == (0, ["weld.mod"])
    Path("mixed/part.glb").unlink()
    code, text = verified("mixed")
    assert (code, "part.glb is missing" in text) == (1, True)

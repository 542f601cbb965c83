"""What a shop says once: who comes first, what is refused, and that a result says where its options came from."""

import json
import shutil
from pathlib import Path

import pytest

from tests.running import Ended, run_here

ROOT = Path(__file__).parents[3]
PAIRS = ROOT / "fixtures" / "yin2003" / "table1.csv"


def fitted(folder: Path, shop: str, *words: str) -> Ended:
    (folder / "wpcal.toml").write_text(shop, encoding="utf-8")
    (folder / "pairs.csv").write_bytes(PAIRS.read_bytes())
    return run_here("fit", folder / "pairs.csv", "--json", *words)


def tolerance_of(done: Ended) -> float:
    assert done.returncode in (0, 1), done.stderr
    return float(json.loads(done.stdout)["tolerance_mm"])


def test_who_says_an_option_first_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert tolerance_of(fitted(tmp_path, "")) == 0.5
    assert tolerance_of(fitted(tmp_path, "tolerance_mm = 0.31")) == 0.31
    assert tolerance_of(fitted(tmp_path, "tolerance_mm = 0.31\n[fit]\ntolerance_mm = 0.32")) == 0.32
    monkeypatch.setenv("WPCAL_TOLERANCE_MM", "0.33")
    done = fitted(tmp_path, "tolerance_mm = 0.31")
    assert tolerance_of(done) == 0.33
    assert "the shop says --tolerance-mm 0.33" in done.stderr
    done = fitted(tmp_path, "tolerance_mm = 0.31", "--tolerance-mm", "0.34")
    assert (tolerance_of(done), done.stderr) == (0.34, "")


def test_the_nearest_file_upwards_from_the_part_is_read(tmp_path: Path) -> None:
    (tmp_path / "wpcal.toml").write_text("tolerance_mm = 0.1")
    inner = tmp_path / "customer" / "part"
    inner.mkdir(parents=True)
    (inner.parent / "wpcal.toml").write_text("tolerance_mm = 0.2")
    (inner / "pairs.csv").write_bytes(PAIRS.read_bytes())
    assert tolerance_of(run_here("fit", inner / "pairs.csv", "--json")) == 0.2


@pytest.mark.parametrize(
    ("shop", "said"),
    [
        ("tolerence_mm = 1", "unknown key 'tolerence_mm'; did you mean tolerance_mm?"),
        ("out = 'x'", "unknown key 'out'"),
        ("[fit]\nforce = true", "unknown key '[fit] force'"),
        ("[fti]\ntolerance_mm = 1", "unknown table [fti]; did you mean fit?"),
        ("[fit]\nclearance_mm = 1", "[fit] clearance_mm: `wpcal fit` has no such option"),
        ("tolerance_mm = 'wide'", "tolerance_mm: expected a number, got 'wide'"),
        ("tolerance_mm = true", "tolerance_mm: expected a value, got True"),
        ("tolerance_mm = [1]", "tolerance_mm: expected one value, got a list"),
        ("criterion = 'best'", "criterion: 'best' is not one of"),
        ("tolerance_mm =", "is not TOML"),
    ],
)
def test_a_wrong_file_is_one_line_that_names_it(tmp_path: Path, shop: str, said: str) -> None:
    done = fitted(tmp_path, shop)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert f"{tmp_path / 'wpcal.toml'}: {said}" in done.stderr


def test_files_are_named_from_the_folder_of_the_shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from wpcal.cli.command_group import installed_commands
    from wpcal.cli.shop_file import find_shop, said_of

    (tmp_path / "csv").mkdir()
    (tmp_path / "straight").mkdir()
    text = (
        "robot = 'arms/kr.json'\ncell = 'cell.json'\ntorch = 'straight'\n[export]\nformat = ['csv']\ntool = '0,0,300.5'"
    )
    (tmp_path / "wpcal.toml").write_text(text)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "cell.json").write_text("{}")
    monkeypatch.chdir(elsewhere)
    shop = find_shop([str(tmp_path)])
    commands = dict(installed_commands())
    said = said_of(commands["export"], "export", shop)
    assert said["robot"].value == str(tmp_path / "arms" / "kr.json")
    assert (said["formats"].value, said["formats"].origin) == (["csv"], "wpcal.toml [export]")
    assert said["tool"].value == "0,0,300.5"
    (tmp_path / "wpcal.toml").write_text("[pick]\nrobot = 'ur:robot.local,tool=2'")
    pick = said_of(dict(installed_commands())["pick"], "pick", find_shop([str(tmp_path)]))
    assert pick["robot"].value == "ur:robot.local,tool=2"
    assert said_of(commands["seams"], "seams", shop)["torch"].value == "straight"
    assert said_of(commands["touches"], "touches", shop)["cell"].value == str(tmp_path / "cell.json")


def test_the_part_says_which_shop_and_not_the_value_of_an_option(tmp_path: Path) -> None:
    from wpcal.cli.command_group import installed_commands
    from wpcal.cli.shop_file import Typed, typed

    fit = dict(installed_commands())["fit"]
    words = ["--tolerance-mm", "other", "--seed", "3", "--json", "pairs.csv"]
    assert typed(fit, words) == Typed(("pairs.csv",), frozenset({"tolerance_mm", "seed", "as_json"}))
    assert typed(fit, ["--no-such-option"]) == Typed()


def test_a_variable_that_is_nearly_one_is_not_left_out_silently(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WPCAL_CACHE_MB", "10")
    assert fitted(tmp_path, "").returncode in (0, 1)
    monkeypatch.setenv("WPCAL_TOLERENCE_MM", "0.1")
    done = fitted(tmp_path, "")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "WPCAL_TOLERENCE_MM; did you mean WPCAL_TOLERANCE_MM?" in done.stderr


@pytest.mark.parametrize(("answer", "said"), [(".5", "tolerance_mm = 0.5\n"), ("0,5", None), ("nan", None)])
def test_an_answer_is_tried_before_the_file_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answer: str, said: str | None
) -> None:
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    answers = iter([answer, "", r"C:\torches\new.json"])
    monkeypatch.setattr("click.prompt", lambda *_args, **_options: next(answers, ""))
    out = tmp_path / "wpcal.toml"
    done = run_here("shop", "new", "-o", out)
    if said is None:
        assert (done.returncode, done.stderr.count("\n"), out.exists()) == (2, 1, False)
    else:
        assert done.returncode == 0, done.stderr
        assert said in out.read_text()
        assert run_here("shop", "new", "-o", out, "--force").returncode == 0


def test_a_new_file_of_a_shop_says_nothing_until_it_is_edited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run_here("shop", "new").returncode == 0
    shown = json.loads(run_here("shop", "--json").stdout)
    assert (shown["file"], shown["values"]) == (str(tmp_path / "wpcal.toml"), [])
    lines = [line.removeprefix("# ") for line in (tmp_path / "wpcal.toml").read_text().splitlines() if " = " in line]
    (tmp_path / "wpcal.toml").write_text("\n".join(lines))
    values = json.loads(run_here("shop", "--json").stdout)["values"]
    assert {each["option"] for each in values} >= {"--tolerance-mm", "--sigma-mm", "--torch", "--robot", "--format"}
    assert run_here("shop", "new").returncode == 2


def test_the_first_screen_of_the_help_is_short_and_all_is_one_word_away() -> None:
    first, whole = (run_here("calibrate", flag).stdout for flag in ("--help", "--help-all"))
    flags = [line.split()[0] for line in first.splitlines() if line.startswith("  -")]
    assert len(flags) <= 20
    assert {"--tolerance-mm", "--bodies"} <= set(flags)
    assert "more options: wpcal calibrate --help-all" in first
    assert whole.count("\n  -") > 40
    assert run_here("help", "calibrate").stdout == first
    assert run_here("-V").stdout == run_here("--version").stdout


def test_alone_in_a_folder_the_next_command_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tee = ROOT / "fixtures" / "tee"
    assert "next:" not in run_here().stdout
    (tmp_path / "a part.step").write_bytes((tee / "tee.step").read_bytes())
    assert "next: wpcal pick 'a part.step'" in run_here().stdout
    (tmp_path / "taught.csv").write_text("name,x_mm,y_mm,z_mm\nweb,,,\n")
    assert "next: wpcal pick 'a part.step'" in run_here().stdout
    (tmp_path / "taught.csv").write_bytes((tee / "taught.csv").read_bytes())
    assert "next: wpcal calibrate 'a part.step' taught.csv -o out" in run_here().stdout
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "calibration.json").write_bytes((tee / "golden" / "calibration.json").read_bytes())
    assert "next: wpcal export out" in run_here().stdout


@pytest.mark.parametrize(
    ("shop", "code", "said"),
    [
        ("standoff_mm = 15", 2, "--standoff-mm 15 (wpcal.toml): the plan of touches has 0"),
        ("tool_axis = 'x'", 2, "--tool-axis x (wpcal.toml): the plan of touches has z"),
        ("standoff_mm = 0\napproach_mm = 20", 0, "of what the shop says is not used here: --approach-mm\n"),
    ],
)
def test_a_plan_of_touches_has_its_tool_and_a_shop_no_other(tmp_path: Path, shop: str, code: int, said: str) -> None:
    (tmp_path / "wpcal.toml").write_text(shop)
    plan = shutil.copytree(ROOT / "fixtures" / "tee" / "touches_plan", tmp_path / "plan")
    done = run_here("export", plan, "-f", "rapid")
    assert (done.returncode, said in done.stderr) == (code, True), done.stderr


@pytest.mark.parametrize(
    ("shop", "said"), [("standoff_mm = 15", "STANDOFF_MM=0"), ("[export]\ntool_axis = 'x'", "TOOL_AXIS=z")]
)
def test_the_programs_of_a_plan_have_the_tool_of_its_cell(tmp_path: Path, shop: str, said: str) -> None:
    (tmp_path / "wpcal.toml").write_text(shop)
    (tmp_path / "plan.json").write_text("{}")
    cell = shutil.copy(ROOT / "fixtures" / "cells" / "two-mh6-tee.json", tmp_path)
    seams = ROOT / "fixtures" / "tee" / "golden" / "seams.json"
    for words in (("plan", cell, seams, "-o", tmp_path / "out"), ("export", tmp_path, "-f", "rapid")):
        done = run_here(*words)
        assert (done.returncode, f"say so in the shop, or WPCAL_{said}" in done.stderr) == (2, True), done.stderr

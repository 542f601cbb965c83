"""What a shop says once: who comes first, what is refused, and that a result says where its options came from."""

from __future__ import annotations

import json
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


def test_files_are_named_from_the_folder_of_the_shop(tmp_path: Path) -> None:
    from wpcal.cli.command_group import installed_commands
    from wpcal.cli.shop_file import find_shop, said_of

    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "kr.json").write_text("{}")
    (tmp_path / "wpcal.toml").write_text("robot = 'arms/kr.json'\ntorch = 'straight'\n[export]\nformat = ['krl']")
    shop = find_shop([str(tmp_path)])
    said = said_of(dict(installed_commands())["export"], "export", shop)
    assert said["robot"].value == str(tmp_path / "arms" / "kr.json")
    assert (said["formats"].value, said["formats"].origin) == (["krl"], "wpcal.toml [export]")


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
    (tmp_path / "taught.csv").write_bytes((tee / "taught.csv").read_bytes())
    assert "next: wpcal calibrate 'a part.step' taught.csv -o out" in run_here().stdout
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "calibration.json").write_bytes((tee / "golden" / "calibration.json").read_bytes())
    assert "next: wpcal export out" in run_here().stdout

"""`wpcal export` and `wpcal taught` as a user calls them."""

import json

import pytest

from wpcal.cli.main import run


def call(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        run([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def files_below(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_programs_are_written_below_the_calibration(finished_folder, capsys):
    folder = finished_folder()
    code, out, err = call(capsys, "export", folder, "-f", "rapid", "-f", "krl", "--json")
    assert (code, err.count("wpcal: ")) == (0, 1)  # that nothing says who wrote the result
    assert json.loads(out)["seams"] == ["W1", "Kehlnaht Ü/3"]
    expected = ["calibration.json", "krl/WPCAL.dat", "krl/WPCAL.src", "part.glb", "rapid/WPCAL.mod", "seams.json"]
    assert files_below(folder) == expected


def test_the_same_call_twice_gives_the_same_bytes_and_needs_force(finished_folder, capsys):
    folder = finished_folder()
    assert call(capsys, "export", folder, "-f", "krl")[0] == 0
    first = (folder / "krl" / "WPCAL.src").read_bytes()
    code, _, err = call(capsys, "export", folder, "-f", "krl")
    assert code == 2
    assert "--force" in err
    assert call(capsys, "export", folder, "-f", "krl", "--force")[0] == 0
    assert (folder / "krl" / "WPCAL.src").read_bytes() == first


def test_a_missed_tolerance_ends_with_one_and_the_files_say_so(finished_folder, capsys):
    folder = finished_folder(verdict="FAIL")
    code, _, err = call(capsys, "export", folder, "-f", "rapid")
    assert code == 1
    assert "verdict of the calibration is FAIL" in err
    assert "calibration FAIL" in (folder / "rapid" / "WPCAL.mod").read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-f", "fortran"], "unknown format 'fortran'; known: "),
        (["-f", "rapdi"], "unknown format 'rapdi': did you mean rapid? known: abb, "),
        (["-f", "rapid", "--config", "fanuk=N U T, 0, 0, 0"], "unknown format 'fanuk': did you mean fanuc?"),
        (["-f", "rapid", "--only", "W9"], "unknown seam W9"),
        (["-f", "rapid", "--all", "--only", "W1"], "either --only or --all"),
        (["-f", "rapid", "--work-angle-deg", "80"], "work angle: expected -60 to 60 deg, got 80"),
        (["-f", "rapid", "--speed-mm-s", "0"], "0.0 is not in the range x>0"),
        (["-f", "rapid", "--robot", "mh6", "--near-joints", "0,0,0,0,0,0"], "--robot needs --tool"),
        (["-f", "rapid", "--robot", "mh6", "--near-joints", "0,0,0,0,0,1_0"], "--robot needs --near-joints"),
    ],
)
def test_wrong_use_ends_with_two_in_one_line_and_writes_nothing(finished_folder, capsys, options, message):
    folder = finished_folder()
    code, out, err = call(capsys, "export", folder, *options)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert files_below(folder) == ["calibration.json", "part.glb", "seams.json"]


def test_force_removes_the_jobs_of_seams_that_are_no_longer_welded(finished_folder, capsys):
    folder = finished_folder(accepted=(True, True, True))
    given = ("export", folder, "-f", "fanuc", "--config", "N U T, 0, 0, 0")
    assert call(capsys, *given)[0] == 0
    out = folder / "fanuc"
    first = {path.name for path in out.iterdir()}
    (out / "MINE.LS").write_text("/PROG MINE\n")
    (out / "notes.txt").write_text("kept")
    code, out_text, err = call(capsys, *given, "--only", "W1", "--force")
    assert (code, "fanuc: 1 seam, " in out_text) == (0, True)
    assert {path.name for path in out.iterdir()} == {"WPCAL.ls", "W1.ls", "MINE.LS", "notes.txt"}
    gone = ", ".join(sorted(first - {"WPCAL.ls", "W1.ls"}))
    assert f"{out}: removed jobs of an earlier export: {gone}" in err
    assert "kept, and not part of this export: MINE.LS" in err
    assert "notes.txt" not in err
    code, _, err = call(capsys, *given, "--only", "W1", "--force")
    assert (code, "removed" in err) == (0, False)


@pytest.mark.parametrize(
    ("typed", "written"),
    [("abb", "rapid"), ("KUKA", "krl"), ("motoman", "inform"), ("ur", "urscript"), ("Kawasaki", "as")],
)
def test_a_maker_is_a_name_of_its_language(finished_folder, capsys, typed, written):
    folder = finished_folder()
    code, out, _ = call(capsys, "export", folder, "-f", typed, "-f", written, "--config", "yaskawa=1,0,0,0,0,0")
    assert (code, out.count("seams")) == (0, 1)
    assert out.startswith(f"{written}: ")
    assert [path.name for path in folder.iterdir() if path.is_dir()] == [written]


def test_the_formats_are_listed(capsys, tmp_path):
    code, out, _ = call(capsys, "export", tmp_path, "-f", "list")
    assert code == 0
    assert "rapid" in out


def test_taught_points_become_a_table(tmp_path, capsys):
    program = tmp_path / "teach.dat"
    program.write_text("DEFDAT T\nDECL E6POS XP1={X 10,Y 20,Z 30,A 0,B 0,C 0}\nENDDAT\n")
    table = tmp_path / "taught.csv"
    code, _, err = call(capsys, "taught", program, "-o", table)
    assert code == 2
    assert "does not say its user frame; give it as X,Y,Z,A,B,C or as base (--uframe)" in err
    assert not table.exists()
    assert call(capsys, "taught", program, "--uframe", "100,0,0,90,0,0", "-o", table)[0] == 0
    header, row = table.read_text().splitlines()
    assert header == "name,x_mm,y_mm,z_mm,feature,rx_deg,ry_deg,rz_deg"
    assert row == "XP1,80.000000,10.000000,30.000000,XP1,0.0000,0.0000,90.0000"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--uframe", "base", "--uframe", "base"], "is given twice"),
        (["--uframe", "3="], "expected [NAME=]VALUES"),
        (["--uframe", "wobj7"], "the file contains no such frame; it contains none"),
        (["--uframe", "1,2"], "expected X,Y,Z,A,B,C as on the pendant"),
        (["--uframe", "base", "--tool", "1,2"], "--tool: a tool is three or six numbers"),
        (["--uframe", "base", "--points", "P9"], "has no point P9; it has XP1"),
    ],
)
def test_wrong_frames_end_with_two(tmp_path, capsys, options, message):
    program = tmp_path / "teach.dat"
    program.write_text("DEFDAT T\nDECL E6POS XP1={X 10,Y 20,Z 30,A 0,B 0,C 0}\nENDDAT\n")
    code, out, err = call(capsys, "taught", program, *options)
    assert (code, out) == (2, "")
    assert message in err


def test_a_limit_of_one_format_keeps_all_from_being_written(finished_folder, capsys):
    folder = finished_folder()
    code, out, err = call(
        capsys, "export", folder, "-f", "krl", "-f", "fanuc", "--config", "N U T, 0, 0, 0", "--speed-mm-s", "8.05"
    )
    assert (code, out) == (2, "")
    assert "FANUC: 8.05 mm/s is neither" in err
    assert files_below(folder) == ["calibration.json", "part.glb", "seams.json"]


def test_each_format_has_its_own_configuration(finished_folder, capsys):
    folder = finished_folder()
    both = ["export", folder, "-f", "fanuc", "-f", "inform"]
    assert call(capsys, *both)[0] == 2
    code, _, err = call(capsys, *both, "--config", "N U T, 0, 0, 0")
    assert code == 2
    assert 'with more than one format: --config inform="1,0,0,0,0,0,0,0"' in err
    assert call(capsys, *both, "--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0")[0] == 0
    assert "given twice" in call(capsys, *both, "--config", "fanuc=a", "--config", "fanuc=b")[2]


@pytest.mark.parametrize(("format_name", "longest"), [("rapid", 32), ("val3", 15)])
def test_a_tool_that_the_language_cannot_name_is_refused(finished_folder, capsys, format_name, longest):
    folder = finished_folder()
    assert call(capsys, "export", folder, "-f", format_name, "--tool-name", "t" * longest)[0] == 0
    for name in ("t" * (longest + 1), "my torch", "for"):
        code, _, err = call(capsys, "export", folder, "-f", format_name, "--tool-name", name, "--force")
        assert code == 2
        assert f"tool '{name}'" in err
        assert f"up to {longest} letters" in err

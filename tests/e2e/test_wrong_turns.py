"""What a newcomer does wrong with files, names, pipes and words: one line says what to do, and nothing is written."""

import gzip
import os
import shutil
import zipfile
from pathlib import Path

import pytest

from tests.running import run_here

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
pytestmark = pytest.mark.usefixtures("kernel_here")

LONG = "a" * 300
FILES = {
    "doc.step": b"%PDF-1.7\n",
    "mesh.step": b"solid part\nfacet normal 0 0 1\n",
    "part.igs": b" " * 72 + b"S      1\n",
    "table.xlsx": b"PK\x03\x04[Content_Types].xml",
    "excel.csv": b"PK\x03\x04\xff\xfe",
    "xyz.csv": b"name,x,y,z\nV2,1,2,3\n",
    "empty.csv": b"",
    "seams.json": b"{}",
    "header.csv": b"name,x_mm,y_mm,z_mm\n",
    "two.csv": b"name,x_mm,y_mm,z_mm\nV2,1,2,3\nV4,4,5,6\n",
    "twice.csv": b"name,x_mm,y_mm,z_mm\nV2,1,2,3\nV2,1,2,3\nV4,4,5,6\nV6,7,8,0\n",
    "other.csv": b"name,x_mm,y_mm,z_mm\nV2,1,2,3\nV99,1,2,3\nV4,4,5,6\nV6,7,8,0\n",
    "template.csv": b"name,x_mm,y_mm,z_mm,use\nV2,,,,yes\nV4,,,,yes\nV6,,,,yes\n",
}

TURNS = [
    ("features te.step", "te.step: no such file or directory; did you mean tee.step?"),
    ("features tee.STEP", "did you mean tee.step?"),
    ("features doc.step", "is a PDF; expected a STEP file (ISO-10303-21); save the part as STEP in the CAD program"),
    ("features mesh.step", "is an STL mesh; expected a STEP file (ISO-10303-21); save the part as STEP in the CAD"),
    ("features part.igs", "is an IGES file; expected a STEP file"),
    ("features stored.step", "is a zip archive: unpack it first"),
    ("features tee.stpz", "is a gzip archive: unpack it first"),
    ("features half.step", "the data section does not end; the file is cut off"),
    ("tee.step", "tee.step is a file; a command comes first, as in: wpcal features tee.step"),
    ("calibrate tee.step", "Missing argument 'TAUGHT'; usage: wpcal calibrate [OPTIONS] PART.step [TAUGHT]; -h ex"),
    ("calibrate tee.step taught.csv", "Missing option '-o' / '--out': Output: "),
    ("calibrate taught.csv tee.step -o new", "are two files swapped?"),
    ("calibrate tee.step table.xlsx -o new", "is a spreadsheet (or another ZIP archive): save the sheet as CSV"),
    ("calibrate tee.step excel.csv -o new", "is a spreadsheet (or another ZIP archive): save the sheet as CSV"),
    ("calibrate tee.step xyz.csv -o new", "write x_mm instead of x: the unit is part of the name"),
    ("calibrate tee.step empty.csv -o new", "expected a header line and rows"),
    ("calibrate tee.step header.csv -o new", "has a header and no rows"),
    ("calibrate tee.step template.csv -o new", "template.csv, line 2, column x_mm: the cell is empty"),
    ("calibrate tee.step tauhgt.csv -o new", "did you mean taught.csv?"),
    ("calibrate tee.step taught.csv --tolerance 1 -o new", "'--tolerance-mm'"),
    ("calibrate tee.step taught.csv -o tee.step", "is a file, expected a folder to write into"),
    ("pick taught.csv --no-browser", "taught.csv: is not STEP text; expected a STEP file"),
    ("sheet tee.step -o sheet.doc", "unknown kind of sheet '.doc'; known: .pdf, .svg, .dxf, .png"),
    ("export result -f abb", "result: no such folder; expected the folder of a finished calibration"),
    ("export seams.json -f abb", "seams.json: is not a folder; expected the folder of a finished calibration"),
    ("export result", "usage: wpcal export [OPTIONS] DIR"),
    ("export result -f kuka,abb", "is more than one format; give each by itself: -f kuka -f abb"),
    ("calibrate tee.step two.csv -o new", "at least 3 points"),
    ("calibrate tee.step twice.csv -o new", "appears twice, first in line 2"),
    ("calibrate tee.step other.csv -o new", "the part has no feature 'V99'; near: "),
    ("features pipe.step", "pipe.step: is a pipe, expected a STEP file"),
    ("features endless.step", "endless.step: is a device"),
    ("fit pipe.csv", "pipe.csv: is a pipe"),
    ("fit endless.csv", "endless.csv: is a device"),
    ("calibrate tee.step pipe.csv -o new", "pipe.csv: is a pipe"),
    ("features x\udcff.step", r"x\xff.step: the name is not UTF-8 text; rename the file or the folder"),
    ("calibrate tee.step taught.csv -o x\udcff", r"x\xff: the name is not UTF-8 text"),
    *(
        (f"{typed.replace('LONG', LONG)}", "file name too long")
        for typed in (
            "calibrate tee.step taught.csv -o LONG",
            "advise tee.step -o LONG.csv",
            "sheet tee.step -o LONG.svg",
            "pick tee.step --no-browser -o LONG.csv",
            "export LONG -f rapid -o new",
            "diff LONG LONG",
            "report LONG",
        )
    ),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("newcomer")
    for name in ("tee.step", "taught.csv"):
        shutil.copy(TEE / name, found)
    part = (TEE / "tee.step").read_bytes()
    for name, data in {**FILES, "tee.stpz": gzip.compress(part), "half.step": part[: len(part) // 2]}.items():
        (found / name).write_bytes(data)
    with zipfile.ZipFile(found / "stored.step", "w") as archive:
        archive.write(found / "tee.step", "tee.step")
    for kind in ("step", "csv"):
        os.mkfifo(found / f"pipe.{kind}")
        (found / f"endless.{kind}").symlink_to("/dev/zero")
    return found


@pytest.mark.parametrize(("typed", "says"), TURNS)
def test_one_line_says_what_to_do(folder: Path, typed: str, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    done = run_here(*typed.split())
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done
    assert says in done.stderr
    assert sorted(folder.iterdir()) == before

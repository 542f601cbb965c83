"""The registry of controllers, and a controller that another package adds with one folder and one entry-point line."""

import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.cli.main import run
from wpcal.controllers import Controller, controller_named, controllers
from wpcal.controllers.audit import audit_path
from wpcal.controllers.audit.programs import read_poses_back
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.program.coordinated_program import SyncProgram
from wpcal.controllers.program.two_robots import possible_programs, sync_languages, write_programs
from wpcal.controllers.registry import CONTROLLERS, controller_of_file
from wpcal.controllers.taught_program import read_taught_program
from wpcal.core.errors import FormatError, InputError
from wpcal.formats import exporter_names
from wpcal.robot.kinematics.arm_file import find_arm

FOLDER = {
    "__init__.py": """
        from wpcal.controllers import Controller

        ACME = Controller(
            name="acme",
            title="Acme: NAME.acme",
            writer="acme_robots.write:write",
            suffixes=(".acme",),
            reader="acme_robots.read:READER",
            sync_writer="acme_robots.sync:write",
        )
        """,
    "write.py": """
        def write(program):
            lines = [f"{path.seam.name} {p}" for path in program.paths for p in path.p_base.tolist()]
            return {f"{program.controller.program_name}.acme": "\\n".join(lines)}
        """,
    "read.py": """
        import numpy as np

        from wpcal.taught.programs import ProgramPoint, ProgramPoints, ProgramReader
        from wpcal.taught.programs import frame_from_angles

        def read(text, path):
            rows = [line.split() for line in text.splitlines()]
            points = [
                ProgramPoint(name, line, np.array(p, dtype=float), np.eye(3), frame)
                for line, (name, frame, *p) in enumerate(rows, start=1)
            ]
            return ProgramPoints(tuple(points))

        READER = ProgramReader(read, frame_from_angles, "X,Y,Z,RX,RY,RZ")
        """,
    "sync.py": """
        def write(program):
            return {f"{program.seam}_R{robot}.acme": str(len(program)) for robot in (1, 2)}
        """,
}


def install(folder: Path, monkeypatch, files, line: str) -> None:
    """Lay out a package and its metadata as an installer does, for one test."""
    for name in ("acme_robots", "acme_robots.write", "acme_robots.read", "acme_robots.sync"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(folder)
    package = folder / "acme_robots"
    package.mkdir()
    for name, text in files.items():
        (package / name).write_text(textwrap.dedent(text))
    metadata = folder / "acme_robots-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-robots\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[{CONTROLLERS}]\n{line}\n")


@pytest.fixture
def acme(tmp_path, monkeypatch):
    install(tmp_path, monkeypatch, FOLDER, "acme = acme_robots:ACME")


@pytest.mark.usefixtures("acme")
def test_a_language_without_a_grammar_is_never_called_checked(finished_folder, tmp_path):
    program = tmp_path / "WPCAL.acme"
    program.write_text("W1 base 1 2 3\n")
    with pytest.raises(InputError, match=r"WPCAL\.acme: no language is known whose programs are \.acme files"):
        read_poses_back(program.read_bytes(), program, None)
    with pytest.raises(InputError, match="nothing is audited"):
        audit_path(program)


def two_robots() -> SyncProgram:
    arms = (find_arm("irb1600_6_12"), find_arm("mh6"))
    return SyncProgram("W1", arms, (np.zeros((4, 6)), np.zeros((4, 6))), np.ones(3), 1, 2)


@pytest.mark.usefixtures("acme")
def test_a_new_controller_is_listed_and_written(finished_folder, tmp_path, capsys):
    assert "acme" in exporter_names()
    with pytest.raises(SystemExit) as ended:
        run(["export", str(finished_folder()), "-f", "acme", "-o", str(tmp_path / "out")])
    assert ended.value.code == 0
    assert (tmp_path / "out" / "acme" / "WPCAL.acme").read_text().startswith("W1 ")
    assert "NOT CHECKED: the written program: acme has no interpreter" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        run(["export", str(tmp_path), "-f", "list"])
    assert "acme       Acme: NAME.acme" in capsys.readouterr().out


@pytest.mark.usefixtures("acme")
def test_taught_points_of_a_new_controller_are_read(tmp_path):
    program = tmp_path / "TEACH.ACME"
    program.write_text("V1 base 1 2 3\nV2 fixture 10 20 30\n")
    with pytest.raises(FormatError, match=r"line 2: point V2: .*give the user frame as fixture=X,Y,Z,RX,RY,RZ"):
        read_taught_program(program)
    with pytest.raises(SystemExit) as ended:
        run(["taught", str(program), "--uframe", "fixture=100,0,0,0,0,90", "-o", str(tmp_path / "taught.csv")])
    assert ended.value.code == 0
    rows = (tmp_path / "taught.csv").read_text().splitlines()
    assert rows[1:] == [
        "V1,1.000000,2.000000,3.000000,V1,0.0000,0.0000,0.0000",
        "V2,80.000000,10.000000,30.000000,V2,0.0000,0.0000,90.0000",
    ]


@pytest.mark.usefixtures("acme")
def test_a_new_controller_writes_programs_of_two_robots():
    program = two_robots()
    assert sync_languages() == ("acme", "inform", "rapid")
    assert write_programs(program, ["acme"]) == {"W1_R1.acme": "4", "W1_R2.acme": "4"}
    files, _ = possible_programs(program)
    assert {"W1_R1.acme", "WPCAL_R1.mod"} <= set(files)


def test_what_a_controller_cannot_do_is_refused():
    with pytest.raises(InputError, match="urscript: taught points cannot be read"):
        controller_named("urscript").load_reader()
    with pytest.raises(InputError, match="krl has no programs of two robots"):
        controller_named("krl").write_sync(two_robots())
    with pytest.raises(
        InputError,
        match="unknown controller 'karel': did you mean krl\\? known: abb, as, comau, fanuc, inform, kawasaki, krl",
    ):
        controller_named("karel")
    assert controller_of_file(Path("points.csv")) is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"suffixes": (".a",)}, "a reader needs suffixes, and suffixes need a reader"),
        ({"reader": "m:R"}, "a reader needs suffixes, and suffixes need a reader"),
        ({"reader": "m:R", "suffixes": (".A",)}, "expected a suffix as .abc, lower case, got '.A'"),
        ({"reader": "m:R", "suffixes": ("a",)}, "expected a suffix as .abc, lower case, got 'a'"),
    ],
)
def test_a_record_that_contradicts_itself_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        Controller("x", "title", "m:write", **changes)


def use_everything(program) -> None:
    for controller in controllers():
        controller.write(program)
        controller_of_file(Path("x.ls"))
        if controller.reader is not None:
            controller.load_reader()


@pytest.mark.parametrize(
    ("line", "old", "new", "message"),
    [
        ("acme = acme_robots:NOTHING", "", "", "'acme': acme_robots:NOTHING cannot be loaded"),
        ("acme = acme_robots.read:READER", "", "", "is not a wpcal.controllers.Controller of this name"),
        ("other = acme_robots:ACME", "", "", "is not a wpcal.controllers.Controller of this name"),
        ("acme = acme_robots:ACME", "write:write", "no:write", "acme_robots.no:write cannot be loaded"),
        ("acme = acme_robots:ACME", "read:READER", "write:write", "is not a wpcal.taught.ProgramReader"),
        ("acme = acme_robots:ACME", '".acme"', '".ls"', ".ls files are claimed by acme and fanuc"),
    ],
)
def test_a_package_that_is_wrong_is_named(tmp_path, monkeypatch, make_program, line, old, new, message):
    files = {**FOLDER, "__init__.py": FOLDER["__init__.py"].replace(old, new) if old else FOLDER["__init__.py"]}
    install(tmp_path, monkeypatch, files, line)
    with pytest.raises(InputError, match=message):
        use_everything(make_program())


def test_the_angles_of_a_frame_are_in_the_order_of_the_pendant():
    for name, axes in {"krl": "ZYX", "fanuc": "xyz", "inform": "xyz", "as": "ZYZ", "pdl2": "ZYZ"}.items():
        frame = controller_named(name).load_reader().frame_of_pendant
        R = Rotation.from_euler(axes, [10, 20, 30], degrees=True).as_matrix()
        np.testing.assert_allclose(frame([1, 2, 3, 10, 20, 30]).R, R, rtol=0, atol=1e-12)
        with pytest.raises(InputError, match="expected 6 numbers"):
            frame([0, 0, 0])


def test_routines_that_only_call_each_other_are_entered_and_named_once():
    for file, text in {
        "a.mod": "MODULE a\nPROC one()\ntwo;;\nENDPROC\nPROC two()\none;\nENDPROC\nENDMODULE\n",
        "b.mod": "MODULE b\nPROC main()\nmain;\nENDPROC\nENDMODULE\n",
        "c.src": "DEF c()\nd()\nEND\nDEF d()\nc()\nEND\n",
        "e.as": ".PROGRAM e()\n  CALL f\n.END\n.PROGRAM f()\n  CALL e\n.END\n",
    }.items():
        assert [each.text.count("does not end within 30 calls") for each in execute({file: text}).unknowns] == [1]


def test_a_routine_knows_nothing_of_what_ran_before_it():
    """One that ends between the start of an arc and its end leaves no arc, and no speed of an arc package."""
    text = "DEF one()\nArcMainNG(#ArcOnAfterMoveStd)\nEND\nDEF two()\n$BASE = $NULLFRAME\n$TOOL = $NULLFRAME\n"
    text += "$VEL.CP = 9\nLIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\nEND\n"
    (motion,) = execute({"a.src": text}).motions
    assert (motion.place.speed_mm_s, motion.arc_on) == (9000.0, False)

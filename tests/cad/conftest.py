from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from cad.session.part import PickPart
    from cad.workpiece.workpiece import Workpiece
    from tests.cad.batch_faults import Reference

HERE = Path(__file__).resolve().parent
SHARED_STEP = HERE.parents[2] / "shared" / "step"
FIXTURES = HERE.parents[1] / "fixtures"

sys.path.insert(0, str(HERE))  # the sample and probe modules beside the tests


SEARCHES = (
    *("flare_grooves", "prepared_edges", "flush_sides", "one_piece", "tube_frames", "members", "said_members"),
    *("drawn_beads", "wide_gaps", "line_contacts", "not_welded", "held_fast", "same_room", "small_feet", "crumbs"),
    *("sides", "play", "marked_seams", "closed_in", "copied_groups", "bodies_shown"),
)
"""Tests whose searches on parts of their own are golden as a whole, beside what each test says of them."""


@pytest.fixture(autouse=True)
def _searches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, golden: Any) -> Iterator[None]:
    """Compare all seams that the searches of a test judged, in their order."""
    if request.node.path.stem.removeprefix("test_") not in SEARCHES:
        yield
        return
    from wpcal.seam import detect, search

    found = []

    def judge(*given: Any, **named: Any) -> Any:
        found.append(original(*given, **named))
        return found[-1]

    original = detect.judge_candidates
    for module in (detect, search):
        monkeypatch.setattr(module, "judge_candidates", judge)
    yield
    if found:
        golden(found)


@pytest.fixture(scope="session")
def shared_step() -> Path:
    """Folder of real STEP files made by others."""
    if not SHARED_STEP.is_dir():
        pytest.skip("the folder ../shared/step with real STEP files is not here")
    return SHARED_STEP


@pytest.fixture
def probe(monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of the module with what tests run in a child process, which then finds it."""
    monkeypatch.setenv("PYTHONPATH", str(HERE))
    return "step_probe"


@pytest.fixture(scope="session")
def sample_part() -> Callable[[str], Workpiece]:
    """Sample parts by name, each read once."""
    from cad.workpiece.workpiece import open_workpiece

    return cache(lambda name: open_workpiece(FIXTURES / name / f"{name}.step"))


@pytest.fixture(scope="session")
def tee_for_the_picker() -> PickPart:
    """The T-joint as the picker reads it, once."""
    from cad.session.part import read_pick_part
    from cad.workpiece.seams import SeamChoice
    from wpcal.seam import SeamOptions

    return read_pick_part(FIXTURES / "tee" / "tee.step", options=SeamOptions(), choice=SeamChoice())


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where a picker saves."""
    return tmp_path / "taught.csv"


@dataclass(frozen=True, slots=True)
class Done:
    """What a command left behind."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def wpcal(kernel_here: None, capsys: pytest.CaptureFixture[str]) -> Callable[..., Done]:
    """Run `wpcal …` in this process, its kernel work too.

    Exit code, output and files are those of the command; only starting two processes and loading the kernel is saved.
    """
    from wpcal.cli.main import run

    def call(*arguments: Path | str) -> Done:
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            run([str(argument) for argument in arguments])
        said = capsys.readouterr()
        return Done(int(ended.value.code or 0), said.out, said.err)

    return call


@pytest.fixture(scope="session")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Reference:
    """A batch that nobody disturbs, for the tests of those that are disturbed."""
    from tests.cad.batch_faults import undisturbed

    return undisturbed(tmp_path_factory.mktemp("undisturbed"))

"""The cache of what was found in parts: the same answers as without it, and never an old, damaged or foreign one."""

import os
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.step.new_file import new_step_text
from cad.workpiece import answer_cache
from cad.workpiece.advise import AdviseOptions
from cad.workpiece.answer_cache import AnswerCache, file_identity, key_of, user_cache
from cad.workpiece.seams import SeamChoice
from cad.workpiece.step_file import StepFile
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from tests.running import FINISHED, kernel_work_here, run_here
from tests.samples.graphs import saddle
from wpcal.core import own_code
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions

FIXTURES = Path(__file__).parents[2] / "fixtures"
WRITING = "cad.step.write:write_moved_data"  #: The only work of the kernel on a part that is known.
LINES = (
    "features PART --json",
    "features PART --all",
    "seams PART --json",
    "seams PART --html seams.html --force",
    "seams PART --split-deg 10 --min-length-mm 60 --json",
    "advise PART --count 3 -o advised.csv --force --json",
    "sheet PART advised.csv -o sheet.svg --force --json",
    "match PART taught.csv --json",
    "calibrate PART taught.csv -o out --force --mark-seams --json",
    "calibrate PART taught.csv -o baked --bake --force",
)
"""Commands on one part. Together they ask every question whose answers are kept."""


def write_overlapping(path: Path) -> None:
    """Two pipes that run into each other: the kernel cuts them, and the graph gets more edges."""
    path.write_bytes(
        new_step_text([(name, shape, (0.5, 0.5, 0.5)) for name, shape in saddle(0.0, trimmed=False)], "saddle")
    )


@pytest.fixture
def answers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of answers, empty; commands work in another folder, with the kernel in this process."""
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    monkeypatch.setenv("WPCAL_CACHE", str(tmp_path / "answers"))
    monkeypatch.setattr("cad.work.child.run_in_child", kernel_work_here)
    return tmp_path / "answers"


def ended(lines: Sequence[str], *more: str) -> list[Any]:
    """Run commands; return all that they printed, and at last all that they wrote."""
    for name in ("out", "baked"):
        shutil.rmtree(name, ignore_errors=True)
    ends = [run_here(*line.split(), *more) for line in lines]
    assert not [done.stderr for done in ends if done.returncode not in FINISHED]
    return [*ends, {str(file): file.read_bytes() for file in sorted(Path().rglob("*")) if file.is_file()}]


def refuse_the_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every reading of the part fail, and all work in the kernel's process but the writing of a moved part."""

    def only_writing(target: str, arguments: Any, **settings: Any) -> Any:
        assert target == WRITING
        return kernel_work_here(target, arguments, **settings)

    def unread(*_: Any, **__: Any) -> None:
        raise AssertionError("the kernel reads a part that is known")

    monkeypatch.setattr("cad.work.child.run_in_child", only_writing)
    monkeypatch.setattr("cad.step.read.read_step", unread)


@pytest.mark.parametrize("sample", few(["tee", "overlapping", "lap"], 1))
def test_a_kept_answer_is_byte_for_byte_a_fresh_one(
    sample: str, answers: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if sample == "overlapping":
        write_overlapping(Path("PART"))
        lines = [line for line in LINES if "taught" not in line]
    else:
        Path("PART").write_bytes((FIXTURES / sample / f"{sample}.step").read_bytes())
        Path("taught.csv").write_bytes((FIXTURES / sample / "taught.csv").read_bytes())
        lines = list(LINES) if sample == "tee" else [line for line in LINES if line.split()[0] in ("seams", "advise")]
    fresh = ended(lines, "--no-cache")
    assert not answers.exists()
    first = ended(lines)
    kept = {file.name: file.read_bytes() for file in answers.iterdir()}
    refuse_the_kernel(monkeypatch)
    second = ended(lines)
    assert fresh == first
    assert fresh == second
    assert kept == {file.name: file.read_bytes() for file in answers.iterdir()}


def varied(options: Any) -> Iterator[Any]:
    """Return copies of options, each with one number, text or choice changed, at any depth."""
    for field in fields(options):
        value = getattr(options, field.name)
        if is_dataclass(value):
            yield from (replace(options, **{field.name: other}) for other in varied(value))
        else:
            changed = copy(options)
            object.__setattr__(changed, field.name, "changed")  # past the checks of its value
            yield changed


def test_whatever_an_answer_depends_on_is_in_its_key(monkeypatch: pytest.MonkeyPatch) -> None:
    data, path = b"ISO-10303-21;", Path("a/part.step")
    identity = file_identity(path, data)
    seams, advice, choice = SeamOptions(), AdviseOptions(), SeamChoice()
    keys = [
        key_of("seams", (*identity, seams, choice)),
        key_of("advice", (*identity, seams, choice)),
        key_of("seams", (*file_identity(path, data + b"\n"), seams, choice)),
        key_of("seams", (*file_identity(Path("a/other.step"), data), seams, choice)),
        *(key_of("seams", (*identity, other, choice)) for other in varied(seams)),
        *(key_of("seams", (*identity, seams, other)) for other in varied(choice)),
        *(key_of("advice", (*identity, other, seams, choice)) for other in varied(advice)),
    ]
    monkeypatch.setattr(answer_cache, "versions", lambda: ("another version",))
    keys.append(key_of("seams", (*identity, seams, choice)))
    assert len(set(keys)) == len(keys)
    monkeypatch.undo()
    assert key_of("seams", (*file_identity(Path("b/part.step"), data), seams, choice)) == keys[0]


def test_the_code_and_its_libraries_are_in_every_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("our_code", "our_kernel"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(own_code, "OUR_PACKAGES", ("our_code",))
    monkeypatch.setattr(answer_cache, "KERNEL", "our_kernel")
    found = [answer_cache.versions.__wrapped__()]

    def differs() -> None:
        found.append(answer_cache.versions.__wrapped__())
        assert found[-1] not in found[:-1]

    (tmp_path / "our_code" / "deep").mkdir()
    (tmp_path / "our_code" / "deep" / "rule.py").write_text("LIMIT = 1")
    differs()
    (tmp_path / "our_code" / "deep" / "rule.py").write_text("LIMIT = 2")
    differs()
    (tmp_path / "our_kernel" / "kernel.so").write_bytes(b"\0")
    differs()
    os.utime(tmp_path / "our_kernel" / "kernel.so", ns=(1, 1))
    differs()
    monkeypatch.setattr(answer_cache, "version", lambda name: f"{name} of tomorrow")
    differs()
    monkeypatch.setattr("platform.machine", lambda: "abacus")
    differs()
    monkeypatch.setattr(sys, "version", "4")
    differs()


def counted(cache: AnswerCache, what: str = "question") -> tuple[Callable[[], Any], list[int]]:
    """Return a question, and how often its answer was found."""
    made: list[int] = []

    def make() -> Any:
        made.append(1)
        return {"numbers": np.arange(40.0), "text": "ü"}

    return (lambda: cache.answer(what, ("of",), make)), made


def test_a_damaged_or_foreign_answer_is_found_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = AnswerCache(tmp_path / "answers")
    ask, made = counted(cache)
    ask()
    (file,) = cache.folder.iterdir()  # type: ignore[union-attr]
    good = file.read_bytes()
    ask()
    assert len(made) == 1
    other = AnswerCache(tmp_path / "others")
    counted(other, "another question")[0]()
    (foreign,) = (tmp_path / "others").iterdir()
    flipped = [good[:at] + bytes([good[at] ^ 1]) + good[at + 1 :] for at in range(0, len(good), 7)]
    for content in (b"", b"\0" * 500, good[:-1], good + b"\0", foreign.read_bytes(), *flipped):
        file.write_bytes(content)
        before = len(made)
        np.testing.assert_array_equal(ask()["numbers"], np.arange(40.0))
        assert len(made) == before + 1
        assert file.read_bytes() == good
    file.unlink()
    file.symlink_to(foreign)
    ask()
    assert not file.is_symlink()
    if hasattr(os, "geteuid"):
        mine, before = os.geteuid(), len(made)
        monkeypatch.setattr(os, "geteuid", lambda: mine + 1)
        ask()
        assert len(made) == before + 1


def test_the_oldest_answers_go_when_there_are_too_many(tmp_path: Path) -> None:
    cache = AnswerCache(tmp_path, most_mb=0.004)
    questions = [counted(cache, str(k)) for k in range(12)]
    for place, (ask, _) in enumerate(questions):
        ask()
        for file in tmp_path.iterdir():
            os.utime(file, (file.stat().st_mtime - 10, file.stat().st_mtime - 10))
        questions[0][0]()  # used all the time
        assert sum(file.stat().st_size for file in tmp_path.iterdir()) <= 4000, place
    assert len(questions[0][1]) == 1
    questions[1][0]()
    assert len(questions[1][1]) == 2
    too_large = AnswerCache(tmp_path / "none", most_mb=1e-4)
    counted(too_large)[0]()
    assert not (tmp_path / "none").exists()


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    new, old = tmp_path / "a.new", tmp_path / "b.new"
    for file in (new, old):
        file.write_bytes(b"half")
    os.utime(old, (1, 1))
    counted(AnswerCache(tmp_path))[0]()
    assert new.exists()
    assert not old.exists()


def test_many_at_once_get_whole_answers(tmp_path: Path) -> None:
    cache = AnswerCache(tmp_path, most_mb=0.004)

    def ask(k: int) -> bool:
        found = cache.answer(str(k % 7), (), lambda: np.full(50, k % 7))
        return bool((found == k % 7).all()) and len(found) == 50

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(ask, range(400)))
    assert not [file for file in tmp_path.iterdir() if file.suffix == ".new"]


def test_a_folder_that_cannot_be_written_is_no_reason_to_fail(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    ask, made = counted(AnswerCache(tmp_path / "file" / "answers"))
    ask()
    ask()
    assert len(made) == 2


def test_the_environment_says_where_and_how_much(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WPCAL_CACHE", "off")
    assert user_cache().folder is None
    monkeypatch.setenv("WPCAL_CACHE", str(tmp_path))
    monkeypatch.setenv("WPCAL_CACHE_MB", "12.5")
    assert user_cache() == AnswerCache(tmp_path, 12.5)
    monkeypatch.setenv("WPCAL_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    if sys.platform == "linux":
        assert user_cache().folder == tmp_path / "wpcal"
    for wrong in ("0", "-3", "much", "inf"):
        monkeypatch.setenv("WPCAL_CACHE_MB", wrong)
        with pytest.raises(InputError, match="WPCAL_CACHE_MB: expected a size in MB above 0"):
            user_cache()


def test_a_script_keeps_nothing_unless_it_asks(answers: Path) -> None:
    part = FIXTURES / "lap" / "lap.step"
    fresh = open_workpiece(part)
    assert not answers.exists()
    open_workpiece(part, cache=user_cache())
    again = open_workpiece(part, cache=user_cache())
    assert "step" not in vars(again.source)  # the kernel did not read it
    for field in fields(fresh.graph):
        one, other = getattr(fresh.graph, field.name), getattr(again.graph, field.name)
        if isinstance(one, np.ndarray):
            assert (one.dtype, one.strides) == (other.dtype, other.strides), field.name


def test_answers_are_about_the_bytes_that_were_opened(answers: Path) -> None:
    path = Path("part.step")
    path.write_bytes((FIXTURES / "lap" / "lap.step").read_bytes())
    file = StepFile.open(path, user_cache())
    path.write_bytes((FIXTURES / "tee" / "tee.step").read_bytes())
    assert set(file.content.graph.solid_names) == {"lower", "upper"}
    assert set(StepFile.open(path, user_cache()).content.graph.solid_names) == {"base plate", "web"}
    assert answers.is_dir()

"""What `wpcal rpc` keeps is bounded: parts in memory, answers of a part, handles."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

from cad.rpc.front import MOST_HANDLES, Front
from cad.rpc.open_parts import MOST_PARTS, OpenPart, OpenParts, signature_of
from cad.rpc.warm_answers import MOST_ANSWERS, WarmAnswers
from cad.workpiece.workpiece import Workpiece
from wpcal.core.progress import no_progress


def test_the_parts_that_were_used_last_are_in_memory(tmp_path: Path) -> None:
    parts, files = OpenParts(), [tmp_path / f"{number}.step" for number in range(MOST_PARTS + 1)]
    opened = []
    for number, file in enumerate(files):
        file.write_text("")
        opened.append(OpenPart(file, cast(Workpiece, None), signature_of(file)))
        parts.put(f"p{number}", opened[-1])
        assert parts.get("p0", files[0], no_progress) is opened[0]  # used again and again
    assert list(parts._parts) == [*(f"p{number}" for number in range(2, MOST_PARTS + 1)), "p0"]
    parts.drop(["p0", "p0"])
    assert "p0" not in parts._parts


def test_the_answers_that_were_used_last_are_in_memory() -> None:
    answers, made = WarmAnswers(), list[Any]()

    def ask(number: int) -> int:
        return answers.answer("number", (number,), lambda: made.append(number) or number)  # type: ignore[func-returns-value]

    for number in range(MOST_ANSWERS + 1):
        assert (ask(0), ask(number)) == (0, number)
    assert made == list(range(MOST_ANSWERS + 1))
    ask(1)
    assert made[-1] == 1  # it had made room


def test_the_handle_that_was_not_used_for_the_longest_time_is_closed() -> None:
    front = Front(0, 1)
    for number in range(MOST_HANDLES + 1):
        front._keep({"handle": f"p{number}", "path": "", "sha256": ""})
    assert len(front._handles) == MOST_HANDLES
    assert "p0" not in front._handles

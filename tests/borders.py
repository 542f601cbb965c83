"""Judgements of a number are asked just below a limit, at it and just above it."""

from collections.abc import Callable
from typing import Any

from jinja2.exceptions import SecurityError

from wpcal.core.errors import WpcalError
from wpcal.core.record_check import _WrongError

SIDES = {"<": (True, False, False), "<=": (True, True, False), ">": (False, False, True), ">=": (False, True, True)}


def check_border(judge: Callable[[Any], Any], sign: str, limit: float) -> None:
    """Assert that a judgement changes at a limit; `sign` ends with ~ where round-off decides at the limit itself."""
    step = 1 if isinstance(limit, int) else max(abs(limit), 1e-9) * 1e-7
    said = [bool(judge(value)) for value in (limit - step, limit, limit + step)]
    if sign.endswith("~"):
        said[1] = SIDES[sign[:-1]][1]
    assert tuple(said) == SIDES[sign.removesuffix("~")], said


def refuses(use: Callable[[Any], Any]) -> Callable[[Any], bool]:
    """Judge whether a value is refused."""

    def judge(value: Any) -> bool:
        try:
            use(value)
        except (WpcalError, _WrongError, SecurityError):
            return True
        return False

    return judge

"""The first, cheap cases of a test at each push, and the others in `make deep` (CONTRIBUTING.md, Tests)."""

from collections.abc import Iterable
from typing import Any

import pytest
from _pytest.mark import ParameterSet


def few(cases: Iterable[Any], count: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`, of which those after the first `count` are deep."""
    return [_case(case, [pytest.mark.deep] if k >= count else []) for k, case in enumerate(cases)]


def _case(case: Any, marks: list[pytest.MarkDecorator]) -> Any:
    if isinstance(case, ParameterSet):
        return case._replace(marks=(*case.marks, *marks))
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=marks)

"""Some cases of a law in every run, and all of them in `make deep`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def few(cases: Iterable[Any], count: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`, of which those after the first `count` are deep."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=[pytest.mark.deep] if k >= count else [])
        for k, case in enumerate(cases)
    ]

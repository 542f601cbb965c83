"""Whether another machine computes the same bytes: the versions on which they depend."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.own_code import code_sha256

PACKAGES = ("wpcal", "numpy", "scipy", "cadquery-ocp-novtk")
"""Libraries are named whose arithmetic may differ in the last digit from one version to the next."""


class OtherVersionError(RuntimeError):
    """A worker would compute other bytes."""


@cache
def versions_here() -> Mapping[str, str]:
    """Return names and versions of all on which the bytes of results depend."""
    return {
        **{name: _version(name) for name in PACKAGES},
        "code of wpcal": code_sha256()[:12],
        "Python": ".".join(map(str, sys.version_info[:2])),
        "system": f"{os.name} on {platform.machine()}",
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def difference(asked: Mapping[str, str], there: Mapping[str, str]) -> str:
    """Return the first difference of another machine as words; empty if there is none."""
    for name, value in asked.items():
        if there.get(name) != value:
            return f"{name} is {there.get(name, 'unknown')} there and {value} here"
    return ""


def require_same(asked: Mapping[str, str], there: Mapping[str, str] | BaseException, worker: str) -> None:
    """Refuse a worker that would compute other bytes. Raises `InputError` with the difference."""
    if isinstance(there, BaseException):
        what = f"wpcal does not run there ({type(there).__name__}: {there})"
    else:
        what = difference(asked, there)
    if what:
        raise InputError(f"worker {worker}: {what}; install the same versions on all machines")


def checked_call(asked: Mapping[str, str], function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function on a worker that has the versions of the command.

    Raises `OtherVersionError` when it has others.
    """
    what = difference(asked, versions_here())
    if what:
        from distributed import get_worker

        raise OtherVersionError(f"worker {get_worker().address}: {what}")
    return function(*arguments)

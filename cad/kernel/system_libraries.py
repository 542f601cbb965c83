"""The one system library that the CAD kernel's wheel does not bring along, and what to type where it is missing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from wpcal.core.errors import InputError

LIBGL_HINT = "the CAD kernel needs libGL.so.1, which this system lacks: sudo apt-get install libgl1"


@contextmanager
def libgl_explained() -> Iterator[None]:
    """Turn the failed import of the kernel into one line that says what to type.

    Raises
    ------
    InputError
        In place of an ImportError that names libGL.
    """
    try:
        yield
    except ImportError as error:
        if "libGL" not in str(error):
            raise
        raise InputError(LIBGL_HINT) from None

"""The one system library that the wheel of the CAD kernel does not contain, and how to install it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from wpcal.core.errors import InputError

LIBGL_HINT = "the CAD kernel needs libGL.so.1, which this system lacks: sudo apt-get install libgl1"


@contextmanager
def libgl_explained() -> Iterator[None]:
    """Turn a failed import of the kernel into one line that says how to install libGL.

    Raises `InputError` instead of an ImportError that names libGL.
    """
    try:
        yield
    except ImportError as error:
        if "libGL" not in str(error):
            raise
        raise InputError(LIBGL_HINT) from None

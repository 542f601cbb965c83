"""A system without libGL: one line that says what to type."""

import pytest

from cad.work.system_libraries import libgl_explained
from wpcal.core.errors import InputError


def test_a_missing_libgl_says_what_to_type() -> None:
    with pytest.raises(InputError, match="sudo apt-get install libgl1"), libgl_explained():
        raise ImportError("libGL.so.1: cannot open shared object file: No such file or directory")


def test_any_other_failed_import_stays_what_it_is() -> None:
    with pytest.raises(ImportError, match="nothing else"), libgl_explained():
        raise ImportError("nothing else")

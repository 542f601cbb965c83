"""The kernel's global settings and exceptions do not leak out of the calls that need them."""

from __future__ import annotations

import pytest

from cad.kernel.call import kernel_call, step_settings
from wpcal.core.errors import KernelError


def unit() -> str:
    from OCP.Interface import Interface_Static

    return str(Interface_Static.CVal_s("write.step.unit"))


def test_settings_are_restored_after_use_and_after_an_exception() -> None:
    with step_settings({"write.step.unit": "MM"}):
        before = unit()
        with step_settings({"write.step.unit": "INCH", "write.step.schema": 5}):
            assert unit() == "INCH"
        assert unit() == before
        with pytest.raises(ZeroDivisionError), step_settings({"write.step.unit": "INCH"}):
            raise ZeroDivisionError
        assert unit() == before


@pytest.mark.parametrize("settings", [{"no.such.setting": 1}, {"write.step.unit": "PARSEC"}])
def test_a_setting_that_the_kernel_does_not_take_is_said(settings: dict[str, int | str]) -> None:
    with pytest.raises(KernelError, match=next(iter(settings))), step_settings(settings):
        pass


def test_an_exception_of_the_kernel_is_a_kernel_error() -> None:
    from OCP.gp import gp_Dir

    with pytest.raises(KernelError, match="drawing a line: the CAD kernel failed"), kernel_call("drawing a line"):
        gp_Dir(0.0, 0.0, 0.0)

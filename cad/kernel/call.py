"""Calls into the kernel: its exceptions become `KernelError`, its settings are restored, its printer is silent.

Importing this module silences the printer, which otherwise writes on standard output.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeAlias

import OCP.Standard
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_PrinterOStream
from OCP.STEPCAFControl import STEPCAFControl_Controller

from wpcal.core.errors import KernelError, OutOfMemoryError

KernelObject: TypeAlias = Any  #: Any object of the kernel: OCP has no type information.

Message.DefaultMessenger_s().RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())

KERNEL_EXCEPTIONS: tuple[type[Exception], ...] = tuple(
    value for value in vars(OCP.Standard).values() if isinstance(value, type) and issubclass(value, Exception)
)
"""All of them, because they have no common base class in Python: ``Standard_DomainError`` is not a
``Standard_Failure`` there."""


@contextmanager
def kernel_call(what: str) -> Iterator[None]:
    """Turn any exception of the kernel into a `KernelError` that says what was being done.

    `what`: For the message: ``reading part.step``.
    Raises `KernelError` when the kernel raises, or runs out of memory.
    """
    try:
        yield
    except (MemoryError, OCP.Standard.Standard_OutOfMemory):
        raise OutOfMemoryError(f"{what}: the CAD kernel ran out of memory") from None
    except KERNEL_EXCEPTIONS as error:
        raise KernelError(f"{what}: the CAD kernel failed ({type(error).__name__}: {error})") from None


@contextmanager
def step_settings(settings: Mapping[str, int | str]) -> Iterator[None]:
    """Set the kernel's global settings for STEP files, and restore them at the end, also after an exception.

    `settings`: By the kernel's own names: ``{"write.step.unit": "INCH"}``.
    Raises `KernelError` when the kernel does not know a name or refuses a value.
    """
    STEPCAFControl_Controller.Init_s()  # before this the kernel does not know the names
    before = {name: _setting(name, value) for name, value in settings.items()}
    try:
        for name, value in settings.items():
            _set(name, value)
        yield
    finally:
        for name, value in before.items():
            _set(name, value)


def _setting(name: str, like: int | str) -> int | str:
    """Return the present value of a setting, with the type of `like`."""
    if not Interface_Static.IsPresent_s(name):
        raise KernelError(f"the CAD kernel has no setting {name}")
    return int(Interface_Static.IVal_s(name)) if isinstance(like, int) else str(Interface_Static.CVal_s(name))


def _set(name: str, value: int | str) -> None:
    change = Interface_Static.SetIVal_s if isinstance(value, int) else Interface_Static.SetCVal_s
    if not change(name, value):
        raise KernelError(f"the CAD kernel refuses {value!r} for its setting {name}")

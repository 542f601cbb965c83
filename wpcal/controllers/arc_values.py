"""What the writers of arc instructions share: values that a language needs, and texts of numbers."""

from __future__ import annotations

from wpcal.controllers.program import WeldPath
from wpcal.core.errors import InputError

NO_WEAVE = "the language has no weave; give --weave points, or state null"


def needed(path: WeldPath, name: str, *, language: str, why: str) -> float:
    """Return a number of the weld data that a language cannot do without.

    Parameters
    ----------
    name : str
        Of the value.
    language, why : str
        For the message.

    Raises
    ------
    InputError
        With the command that states it, if it is missing.
    """
    value = getattr(path.values, name)
    if value is None:
        seam = path.seam.name if path.run is None else path.run.weld.name
        raise InputError(f"{language}: weld {seam}: {why}; state it: wpcal welds … --set {seam}:{name}=VALUE")
    return float(value)


def refuse(path: WeldPath, name: str, *, language: str, why: str) -> InputError:
    """Return the error for a value that a language cannot write.

    Parameters
    ----------
    name : str
        Of the value.
    language, why : str
        For the message.
    """
    seam = path.seam.name if path.run is None else path.run.weld.name
    return InputError(f"{language}: weld {seam}: {name}: {why}")


def require_no_weave(path: WeldPath, *, language: str) -> None:
    """Refuse weld data with a weave, for a language that has none.

    Parameters
    ----------
    language : str
        For the message.

    Raises
    ------
    InputError
        When a weave is stated, with values or by the name of its data.
    """
    if path.values.weave is not None or path.values.weave_data is not None:
        raise refuse(path, "weave", language=language, why=NO_WEAVE)


def end_time_s(path: WeldPath) -> float:
    """Return how long the arc burns after the torch has stopped: crater and delay together, s."""
    crater = path.values.crater
    return (0.0 if crater is None else crater.time_s) + (path.values.end_delay_s or 0.0)

"""What a controller's language needs of the arm's configuration, and no reliable source defines, is refused."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import BoolArray
from wpcal.core.errors import InputError


def refuse_first(is_unknown: BoolArray, why: str) -> None:
    """Refuse configurations that are not known.

    Parameters
    ----------
    is_unknown : ndarray of bool, shape (n,)
        For every pose.

    Raises
    ------
    InputError
        With the number of the first such pose, counted from 1.
    """
    if is_unknown.any():
        raise InputError(f"pose {int(np.argmax(is_unknown)) + 1} of {len(is_unknown)}: {why}")

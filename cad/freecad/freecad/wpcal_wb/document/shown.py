# SPDX-License-Identifier: MIT
"""What is drawn of a calibration."""

from __future__ import annotations

from typing import NamedTuple


class Shown(NamedTuple):
    """Which parts of a calibration are drawn.

    Attributes
    ----------
    factor : float. By which residuals are drawn longer; 0 for one that fits.
    frames : bool. Whether every seam frame is drawn.
    on_model, at_pose : bool. Whether it is drawn on the model, and where the part is.
    datums : str. Which seam frames are coordinate systems in the tree: empty for none, `ends` or `all`.
    """

    factor: float = 0.0
    frames: bool = False
    on_model: bool = True
    at_pose: bool = True
    datums: str = ""

# SPDX-License-Identifier: MIT
"""What is drawn of a calibration."""

from __future__ import annotations

from typing import NamedTuple


class Shown(NamedTuple):
    """Which parts of a calibration are drawn."""

    factor: float = 0.0  #: By which residuals are drawn longer; 0 for one that fits.
    frames: bool = False  #: Whether every seam frame is drawn.
    on_model: bool = True  #: Whether it is drawn on the model, and where the part is.
    at_pose: bool = True
    datums: str = ""  #: Which seam frames are coordinate systems in the tree: empty for none, `ends` or `all`.

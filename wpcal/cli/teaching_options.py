"""Options that say how large the teaching error is; `wpcal fit`, `calibrate` and `pick` share them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import BOUND_HELP, SIGMA_HELP

if TYPE_CHECKING:
    from wpcal.calibrate import TeachingError


@dataclass(frozen=True, slots=True, kw_only=True)
class TeachingFlags:
    """How large the teaching error is, as a person states it."""

    sigma_mm: float | None = option("--sigma-mm", type=float, help=SIGMA_HELP)
    bound_mm: float | None = option("--bound-mm", type=float, help=BOUND_HELP)
    tcp_bias_mm: float = option(
        "--tcp-bias-mm", type=float, default=0.0, show_default=True, help="Error of the tool centre point."
    )

    def to_error(self) -> TeachingError:
        """Check the numbers and return them as the calibration takes them."""
        from wpcal.calibrate import TeachingError

        return TeachingError(sigma_mm=self.sigma_mm, bound_mm=self.bound_mm, tcp_bias_mm=self.tcp_bias_mm)

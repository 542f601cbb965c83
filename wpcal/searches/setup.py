"""What the searches need to know of a cell: signal, speeds, times and names; one small TOML file per cell."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TouchSetup:
    """How a cell senses a touch. Every value has a default.

    Parameters
    ----------
    signal : str
        The digital input that turns on at contact: a name (ABB) or a number.
    is_on_high : bool
        Whether contact turns the input on.
    enable : str
        The digital output that switches the sensing voltage on; empty: none.
    search_speed_mm_s, air_speed_mm_s : float
        During a search, and between searches.
    hold_s : float
        Wait after contact, before the place is stored or the robot leaves.
    latency_s, latency_sigma_s : float
        From contact to the place that the controller stores: a systematic error of latency × speed along the
        direction, and its uncertainty.
    repeatability_mm : float
        Standard deviation of a stored place per axis.
    stick_out_sigma_mm : float
        Standard deviation of the wire's length, along the wire.
    with_package : bool
        Use the touch-sensing package of the brand instead of plain instructions.
    """

    signal: str = "diTouch"
    is_on_high: bool = True
    enable: str = ""
    search_speed_mm_s: float = 10.0
    air_speed_mm_s: float = 100.0
    hold_s: float = 0.1
    latency_s: float = 0.0
    latency_sigma_s: float = 0.001
    repeatability_mm: float = 0.1
    stick_out_sigma_mm: float = 0.5
    with_package: bool = False

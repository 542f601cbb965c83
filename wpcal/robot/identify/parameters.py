"""The numbers that identification may change: their names, how they move a model, and the Jacobian of a pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.forward import LINK_SYMBOLS, Frames, LinkMotion, MDHChain, cross, start_frames, walk

POSE_SYMBOLS = ("x", "y", "z", "rx", "ry", "rz")
"""Six numbers of a base or tool: shift of its origin (mm), then turn about its origin (rad)."""
LENGTH_SYMBOLS = frozenset({"d", "a", "x", "y", "z"})  #: Symbols measured in mm; all others are angles in rad.


class Group(Enum):
    """What a parameter belongs to."""

    LINK = "link"
    BASE = "base"
    TOOL = "tool"
    REFLECTOR = "reflector"


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number that identification may change."""

    name: str  #: ``theta1``, ``beta2``, ``base_rz``, ``tool_x``, ``A_y`` (y of the reflector named A).
    group: Group
    symbol: str  #: One of `LINK_SYMBOLS`, or of `POSE_SYMBOLS`.
    index: int = 0  #: Number of the link or reflector, from 0.

    @property
    def is_length(self) -> bool:
        """Whether its unit is mm (otherwise rad)."""
        return self.symbol in LENGTH_SYMBOLS


def link_parameters(chain: MDHChain) -> tuple[Parameter, ...]:
    """Return the four parameters of every link, β in place of d where the next axis is parallel.

    Ordered θ of all links, d or β of all links, a, α: the 24 parameters of Xiong 2015, Table 2, for a 6R arm.
    """
    n = range(len(chain))
    rows = [
        [("theta", i) for i in n],
        [("beta" if chain.hayati[i] else "d", i) for i in n],
        [("a", i) for i in n],
        [("alpha", i) for i in n],
    ]
    return tuple(Parameter(f"{symbol}{i + 1}", Group.LINK, symbol, i) for row in rows for symbol, i in row)


def base_parameters() -> tuple[Parameter, ...]:
    """Return the six numbers of the base in the frame of the measurement."""
    return tuple(Parameter(f"base_{symbol}", Group.BASE, symbol) for symbol in POSE_SYMBOLS)


def tool_parameters() -> tuple[Parameter, ...]:
    """Return the six numbers of the tool on the last link."""
    return tuple(Parameter(f"tool_{symbol}", Group.TOOL, symbol) for symbol in POSE_SYMBOLS)


def reflector_parameters(names: Sequence[str]) -> tuple[Parameter, ...]:
    """Return the position of every reflector in the flange frame."""
    return tuple(
        Parameter(f"{name or 'reflector'}_{symbol}", Group.REFLECTOR, symbol, k)
        for k, name in enumerate(names)
        for symbol in POSE_SYMBOLS[:3]
    )


def parameters_by_name(chain: MDHChain, names: Sequence[str]) -> tuple[Parameter, ...]:
    """Return link parameters by name; any of the five symbols of any link may be asked for.

    Raises `InputError` when a name is unknown or comes twice.
    """
    known = {f"{s}{i + 1}": Parameter(f"{s}{i + 1}", Group.LINK, s, i) for s in LINK_SYMBOLS for i in range(len(chain))}
    for name in names:
        if name not in known:
            raise InputError(
                f"unknown parameter {name!r}; expected theta, d, a, alpha or beta and a link 1-{len(chain)}"
            )
    if len(set(names)) < len(names):
        raise InputError("a parameter is named twice")
    return tuple(known[name] for name in names)


def surrounding_parameters(
    *, free_base: bool, free_tool: bool, reflectors: Sequence[str] | None
) -> tuple[Parameter, ...]:
    """Return the numbers of an unknown base and an unknown tool."""
    base = base_parameters() if free_base else ()
    if not free_tool:
        return base
    return base + (tool_parameters() if reflectors is None else reflector_parameters(reflectors))


def last_link_first(chain: MDHChain, names: Sequence[str] | None) -> tuple[Parameter, ...]:
    """Return all link parameters, or those named, in the order in which identification keeps them.

    Of two that cannot be told apart the one nearer the base stays fixed: of parallel axes 2 and 3 that is d2, the one
    which Hayati's link drops.
    """
    chosen = link_parameters(chain) if names is None else parameters_by_name(chain, names)
    return tuple(sorted(chosen, key=lambda parameter: -parameter.index))


@dataclass(frozen=True, slots=True, eq=False)
class KinematicModel:
    """A chain from the frame of the measurement to the tool, and the reflectors on the tool."""

    chain: MDHChain  #: Its ``T_base_dh0`` starts in the frame of the measurement.
    #: shape (K, 3). Reflectors in the flange frame, mm; one at its origin unless given.
    reflectors_flange: FloatArray = (  # type: ignore[assignment]  # frozen in __post_init__
        (0.0, 0.0, 0.0),
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "reflectors_flange", frozen(self.reflectors_flange))

    def moved(self, parameters: Sequence[Parameter], step: ArrayLike) -> KinematicModel:
        """Return the model with a step added to its parameters; rotations compose on the left of R.

        `step`: shape (m,). mm and rad.
        """
        table = self.chain.table.copy()
        base, tool = np.zeros(6), np.zeros(6)
        reflectors = self.reflectors_flange.copy()
        for parameter, value in zip(parameters, np.asarray(step, dtype=np.float64), strict=True):
            if parameter.group is Group.LINK:
                table[LINK_SYMBOLS.index(parameter.symbol), parameter.index] += value
            elif parameter.group is Group.REFLECTOR:
                reflectors[parameter.index, POSE_SYMBOLS.index(parameter.symbol)] += value
            else:
                (base if parameter.group is Group.BASE else tool)[POSE_SYMBOLS.index(parameter.symbol)] += value
        chain = replace(
            self.chain.with_table(table),
            T_base_dh0=_moved(self.chain.T_base_dh0, base),
            T_dhn_flange=_moved(self.chain.T_dhn_flange, tool),
        )
        return KinematicModel(chain, reflectors)

    def poses(self, theta: ArrayLike, reflector: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return where the reflectors are, shape (N, 3), and the orientations of the flange, shape (N, 3, 3)."""
        angles = np.ascontiguousarray(np.asarray(theta, dtype=np.float64).T)
        *_, last = walk(start_frames(self.chain.T_base_dh0, 1), self.chain.table, angles)
        flange = last.frame.then(self.chain.T_dhn_flange)
        return flange.point(self.reflectors_flange[reflector].T).T, flange.rotations()

    def jacobian(self, parameters: Sequence[Parameter], theta: ArrayLike, reflector: IntArray) -> FloatArray:
        """Return the derivative of the poses with respect to parameters, shape (N, 6, m).

        Rows: turning of the flange (rad), then velocity of the reflector (mm), in the frame of the measurement.
        """
        angles = np.ascontiguousarray(np.asarray(theta, dtype=np.float64).T)
        motions = list(walk(start_frames(self.chain.T_base_dh0, 1), self.chain.table, angles))
        end = motions[-1].frame
        flange = end.then(self.chain.T_dhn_flange)
        p = flange.point(self.reflectors_flange[reflector].T)
        J = np.zeros((6, len(parameters), angles.shape[1]))
        for column, parameter in zip(np.moveaxis(J, 1, 0), parameters, strict=True):
            if parameter.group is Group.LINK:
                _link_column(column, parameter.symbol, motions[parameter.index], p)
            elif parameter.group is Group.REFLECTOR:
                seen = reflector == parameter.index
                column[3:, seen] = flange[POSE_SYMBOLS.index(parameter.symbol)][:, seen]
            elif parameter.group is Group.BASE:
                ex, ey, ez = np.eye(3)[:, :, None]  # of the measurement
                axes = Frames(ex, ey, ez, self.chain.T_base_dh0.t_mm[:, None])
                _pose_column(column, parameter.symbol, axes, p)
            else:
                _pose_column(column, parameter.symbol, end._replace(p=flange.p), p)
        return np.ascontiguousarray(np.moveaxis(J, 2, 0))


def _moved(T: RigidTransform, step: FloatArray) -> RigidTransform:
    if not step.any():
        return T
    return RigidTransform(exp_rotation(step[3:]) @ T.R, T.t_mm + step[:3], T.target, T.source)


def _link_column(column: FloatArray, symbol: str, motion: LinkMotion, p: FloatArray) -> None:
    """Fill the six rows for one link parameter; see `LinkMotion` for the axes."""
    if symbol == "d":
        column[3:] = motion.z
    elif symbol == "a":
        column[3:] = motion.x
    else:
        axis, origin = {
            "theta": (motion.z, motion.p_before),
            "alpha": (motion.x, motion.frame.p),
            "beta": (motion.frame.y, motion.frame.p),
        }[symbol]
        column[:3] = axis
        column[3:] = cross(axis, p - origin)


def _pose_column(column: FloatArray, symbol: str, frame: Frames, p: FloatArray) -> None:
    """Fill the six rows for one number of a base or tool: along or about an axis of `frame`."""
    axis = frame[POSE_SYMBOLS.index(symbol) % 3]
    if symbol in LENGTH_SYMBOLS:
        column[3:] = axis
    else:
        column[:3] = axis
        column[3:] = cross(axis, p - frame.p)


def model_difference(parameters: Sequence[Parameter], start: KinematicModel, end: KinematicModel) -> FloatArray:
    """Values of `end` minus values of `start`, shape (m,), mm and rad; turns as rotation vectors."""
    table = end.chain.table - start.chain.table
    shifts = end.reflectors_flange - start.reflectors_flange
    base = _pose_difference(start.chain.T_base_dh0, end.chain.T_base_dh0)
    tool = _pose_difference(start.chain.T_dhn_flange, end.chain.T_dhn_flange)
    return np.array([_entry(parameter, table, base, tool, shifts) for parameter in parameters])


def _pose_difference(start: RigidTransform, end: RigidTransform) -> FloatArray:
    return np.concatenate([end.t_mm - start.t_mm, log_rotation(end.R @ start.R.T)])


def _entry(parameter: Parameter, table: FloatArray, base: FloatArray, tool: FloatArray, shifts: FloatArray) -> float:
    if parameter.group is Group.LINK:
        return float(table[LINK_SYMBOLS.index(parameter.symbol), parameter.index])
    k = POSE_SYMBOLS.index(parameter.symbol)
    if parameter.group is Group.REFLECTOR:
        return float(shifts[parameter.index, k])
    return float((base if parameter.group is Group.BASE else tool)[k])

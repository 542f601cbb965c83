"""Copies of a shape that are mirrored or scaled where they are placed: the kernel reads them wrongly.

A placement can be a `CARTESIAN_TRANSFORMATION_OPERATOR_3D` (ISO 10303-42). OCCT 8 ignores that it mirrors, and gives a
shape that is scaled by 1.5 two thirds of its size. Seams and features would be in places where the part has nothing.
"""

import math
from collections.abc import Iterator

import numpy as np

from cad.step.part21 import Part21File
from cad.step.part21_values import Instance, Ref, Value
from wpcal.core.errors import InputError

OPERATOR, OPERATOR_3D = "CARTESIAN_TRANSFORMATION_OPERATOR", "CARTESIAN_TRANSFORMATION_OPERATOR_3D"
PLACING = ("MAPPED_ITEM", "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION")  #: What places a shape by an operator.
ROUND_OFF = 1e-9  #: Of a scale that is 1.


def refuse_distorted(file: Part21File, path: str) -> None:
    """Refuse a file that places a copy of a shape mirrored or scaled.

    Raises `InputError` with the instance that says so.
    """
    found = {operator.id: what for operator in file.instances(OPERATOR_3D) if (what := _distortion(file, operator))}
    if not found:
        return
    for keyword in PLACING:
        for placing in file.instances(keyword):
            for number in placing.references():
                if number in found:
                    raise InputError(
                        f"{path}: #{placing.id} places a copy of a shape {found[number]}, which the CAD kernel reads "
                        "wrongly: in the CAD program, make the copy a part of its own and export again"
                    )


def _distortion(file: Part21File, operator: Instance) -> str:
    """Say how an operator changes a shape; empty if it only moves it."""
    axis1, axis2, scale, axis3 = _arguments(operator)
    if isinstance(scale, int | float) and not math.isclose(scale, 1.0, rel_tol=0.0, abs_tol=ROUND_OFF):
        return f"scaled by {scale:g}"
    axes = [list(_numbers(file, axis)) for axis in (axis1, axis2, axis3)]
    is_mirrored = all(len(axis) == 3 for axis in axes) and np.linalg.det(np.array(axes)) < 0.0
    return "mirrored" if is_mirrored else ""


def _arguments(operator: Instance) -> tuple[Value, Value, Value, Value]:
    """Return first and second axis, scale, and third axis; a missing one is None."""
    whole, own = operator.record(OPERATOR), operator.record(OPERATOR_3D)
    assert own is not None  # it was found by this keyword
    given = own.arguments if whole is None else (*whole.arguments, *own.arguments)
    axis1, axis2, _, scale, axis3 = (*([None] * 5), *given)[-5:]
    return axis1, axis2, scale, axis3


def _numbers(file: Part21File, direction: Value) -> Iterator[float]:
    instance = file.instance(direction) if isinstance(direction, Ref) else None
    record = None if instance is None else instance.record("DIRECTION")
    given = record.arguments[-1] if record is not None and record.arguments else ()
    yield from (float(each) for each in (given if isinstance(given, tuple) else ()) if isinstance(each, int | float))

"""Damaged STEP files through features, seams and calibration: an error of ours in one line, and nothing else."""

from pathlib import Path
from typing import Any

import pytest
from OCP.Standard import Standard_DomainError, Standard_OutOfRange

from cad.kernel import canonical, to_brep
from cad.workpiece.workpiece import open_workpiece
from tests.fuzz.chain import READ, in_child
from tests.fuzz.target import FIXTURES
from wpcal.core.errors import FormatError, GeometryError, KernelError

TEE = FIXTURES / "tee" / "tee.step"
COORDINATES = b"CARTESIAN_POINT('',("


def damaged(number: int, values: bytes) -> bytes:
    """The T-joint with other coordinates in one of its points."""
    pieces = TEE.read_bytes().split(COORDINATES)
    pieces[number] = values + pieces[number][pieces[number].index(b")") :]
    return COORDINATES.join(pieces)


@pytest.mark.parametrize("number", [1, 19, 64])
def test_a_point_at_infinity_ends_with_an_error_of_ours(number: int, tmp_path: Path) -> None:
    outcomes = in_child(damaged(number, b"1.E30,0.,0."), tmp_path)
    assert outcomes == [READ, "refused: GeometryError"]


def test_the_message_names_the_file_and_the_solid(tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    path.write_bytes(damaged(19, b"1.E30,0.,0."))
    with pytest.raises(GeometryError, match=r"part\.step: geometry in base plate is infinite or farther away"):
        open_workpiece(path)


def test_a_number_that_is_infinite_for_the_kernel_is_refused_at_its_line(tmp_path: Path) -> None:
    """On an infinite knot the kernel's mesher runs until the time limit of 600 s."""
    path = tmp_path / "part.step"
    path.write_bytes(damaged(19, b"1.E400,0.,0.").replace(b"base plate", b"plate 1.E999 /* 2.E999 */"))
    with pytest.raises(FormatError, match=r"part\.step, line \d+: the number '1\.E400' is too large"):
        open_workpiece(path)
    path.write_bytes(
        TEE.read_bytes().replace(b"base plate", b"plate 1.E999").replace(b"0.,0.)", b"0.E400,0.E+0001)", 1)
    )
    assert "plate 1.E999" in open_workpiece(path).graph.solid_names


@pytest.mark.parametrize("kind", [Standard_OutOfRange, Standard_DomainError])
def test_an_exception_of_the_kernel_on_a_face_is_an_error_of_ours(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_face: Any) -> None:
        raise kind("on this face")

    monkeypatch.setattr(canonical, "_recognised", fail)
    assert canonical.recognise_surface(some_face()) is None  # it counts as free-form
    monkeypatch.setattr(to_brep, "_surface", fail)
    with pytest.raises(KernelError, match=r"^reading the faces of 'block': the CAD kernel failed \(Standard_"):
        to_brep.to_brep([("block", some_solid())])


def some_solid() -> Any:
    from build123d import Box

    return Box(1, 2, 3).wrapped


def some_face() -> Any:
    from cad.kernel.topology import FACE, sub_shape_uses

    return next(iter(sub_shape_uses(some_solid(), FACE)))[0]

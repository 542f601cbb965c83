"""The STEP file of a workpiece: its bytes, and what was found in them, from the cache as far as possible.

The kernel is loaded when something asks for the shapes. An answer that is kept needs neither.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from cad.work.system_libraries import libgl_explained
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache, KernelNeededError, file_identity
from wpcal.brep import BrepGraph
from wpcal.brep.repeats import solid_copies
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError, blamed_on
from wpcal.core.input_file import MOST_STEP_MB, read_bytes
from wpcal.core.issue import Issue
from wpcal.core.process import give_memory_back
from wpcal.taught.features import ReferenceFeature, find_features

if TYPE_CHECKING:
    from cad.step.read import StepPart

Answer = TypeVar("Answer")
PART, MESH, LINES = "part", "mesh", "lines"
"""Questions that the file alone answers: what is in it, its triangles, and its lines in the views of a sheet."""
SMALLEST_MM, LARGEST_MM = 3.0, 40_000.0  #: Diagonals of parts that are welded; others are rather in another unit.


@dataclass(frozen=True, slots=True, eq=False)
class PartContent:
    """What wpcal takes from a STEP file."""

    graph: BrepGraph
    unit: str  #: Length unit of the file.
    issues: tuple[Issue, ...]  #: What is odd in the file.


@dataclass(frozen=True, eq=False)
class StepFile:
    """A STEP file as it was when it was opened: what is found later is found in the same bytes."""

    path: Path  #: As the user named it.
    data: bytes
    cache: AnswerCache = NO_CACHE

    @classmethod
    def open(cls, path: Path | str, cache: AnswerCache = NO_CACHE) -> StepFile:
        """Read the bytes of a STEP file. Raises `InputError` if they cannot be read."""
        return cls(Path(path), read_bytes(Path(path), most_mb=MOST_STEP_MB, expected="a STEP file"), cache)

    @property
    def file_name(self) -> str:
        """Name without the folder."""
        return self.path.name

    @cached_property
    def _identity(self) -> tuple[str, str]:
        return file_identity(self.path, self.data)

    @property
    def sha256(self) -> str:
        """SHA-256 of the file's bytes."""
        return self._identity[0]

    @property
    def unit(self) -> str:
        """Length unit of the file: ``mm``, ``inch``, … The shapes are always in mm."""
        return self.content.unit

    @cached_property
    def step(self) -> StepPart:
        """The file as the kernel reads it.

        Raises `KernelNeededError` if this process must not load the kernel.
        Raises `InputError` or `FormatError` or `KernelError` as `read_step` raises them.
        """
        if not self.cache.kernel:
            raise KernelNeededError
        with libgl_explained():
            from cad.step.read import read_step
        return read_step(self.path, data=self.data)

    def hand_over_step(self) -> StepPart:
        """Return the file as the kernel reads it, and keep nothing of it here."""
        part = self.step
        self.let_shapes_go()
        return part

    def let_shapes_go(self) -> None:
        """Keep nothing of what the kernel read; who asks for `step` after this lets it read the file again.

        The shapes of a large part take as much memory as all else together.
        """
        self.__dict__.pop("step", None)

    @cached_property
    def content(self) -> PartContent:
        """The faces and edges; errors as for `step`."""
        return self.answer(PART, (), self._find_content)

    @cached_property
    def trimmed(self) -> TrimmedFaces:
        """The boundaries of the faces as pieces."""
        trimmed = TrimmedFaces.of(self.content.graph)
        give_memory_back()  # what sampling took
        return trimmed

    @cached_property
    def features(self) -> tuple[ReferenceFeature, ...]:
        """The reference features."""
        return find_features(self.content.graph)

    def answer(self, what: str, of: Sequence[object], make: Callable[[], Answer]) -> Answer:
        """Return an answer about this file that is kept, or find it; parameters as in `AnswerCache.answer`."""
        return self.cache.answer(what, (*self._identity, *of), make)

    def _find_content(self) -> PartContent:
        part = self.step
        if not part.solids:
            found = "; ".join(issue.message for issue in part.issues)
            raise InputError(f"{self.path}: there is nothing to teach or weld on: {found}")
        from cad.kernel.to_brep import to_brep

        with blamed_on(str(self.path)):
            graph = to_brep((solid.name, solid.shape) for solid in part.solids)
        give_memory_back()  # what reading took
        graph = replace(graph, solid_facts=tuple(solid.facts for solid in part.solids))
        return PartContent(graph, part.unit, (*part.issues, *_size_issues(graph, part.unit)))


def _size_issues(graph: BrepGraph, unit: str) -> Iterator[Issue]:
    """Tell of a part that is so large or so small that the unit in its file may be wrong."""
    if not SMALLEST_MM <= graph.size_mm <= LARGEST_MM:
        far = f"{graph.size_mm / 1000:.3g} m" if graph.size_mm > LARGEST_MM else f"{graph.size_mm:.2g} mm"
        text = f"the part is {far} from corner to corner; its file says {unit}: if that is wrong, export it in mm again"
        yield Issue("size", text)


def draw_part(file: StepFile) -> tuple[bytes | None, tuple[Issue, ...]]:
    """Return ``part.glb`` of a STEP file, and what is missing in it (`cad.kernel.tessellate.mesh_part`)."""

    def mesh() -> tuple[bytes | None, tuple[Issue, ...]]:
        solids, copies = file.step.solids, solid_copies(file.content.graph, file.trimmed)
        from cad.kernel.tessellate import mesh_part

        return mesh_part(solids, copies=copies, sha256=file.sha256)

    return file.answer(MESH, (), mesh)

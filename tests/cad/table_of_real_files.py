"""Print how files are moved, for docs/reading-real-files.md: ``python tests/cad/table_of_real_files.py FOLDER``."""

import sys
import tempfile
from pathlib import Path

import numpy as np

from cad.step.compare import take_inventory
from cad.step.read import StepPart, read_document, read_step
from cad.step.write import write_moved_step
from wpcal.core.errors import WpcalError
from wpcal.core.transform import RigidTransform

T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")


def moved(part: StepPart, target: Path, *, bake: bool) -> str:
    """Largest distance of a vertex from where T puts it, and what was different."""
    issues = write_moved_step(part, T_BASE_PART, target, bake=bake)
    before, after = take_inventory(part.document), take_inventory(read_document(target))
    if before.vertices.shape != after.vertices.shape:
        return f"{len(before.vertices)} vertices, then {len(after.vertices)}"
    off = np.linalg.norm(T_BASE_PART.apply(before.vertices) - after.vertices, axis=1).max(initial=0.0)
    return f"{off:.0e}" + "".join(f"; {issue.code}" for issue in issues)


def row(path: Path, target: Path) -> str:
    """One line of the table."""
    try:
        part = read_step(path)
    except WpcalError as error:
        return f"| {path.name} | refused: {str(error).replace(str(path), path.name)} | | | | | |"
    faces = take_inventory(part.document).surfaces.total()
    codes = ", ".join(f"`{code}`" for code in dict.fromkeys(issue.code for issue in part.issues)) or "none"
    columns = [path.name, len(part.solids), faces, part.unit, codes]
    columns += [moved(part, target, bake=False), moved(part, target, bake=True)]
    return f"| {' | '.join(map(str, columns))} |"


def main() -> None:
    print("| file | solids | faces | unit | issues | moved by appending, mm | moved in place, mm |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(Path(sys.argv[1]).glob("*.[sS][tT]*")):
            print(row(path, Path(folder) / "moved.step"))


if __name__ == "__main__":
    main()

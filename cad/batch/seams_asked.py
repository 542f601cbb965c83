"""The options for what a person decides about the seams. Apart from the request, whose fit needs SciPy (0.3 s)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cad.workpiece.seams import SeamChoice
from wpcal.core.options import opt
from wpcal.seam.edit import read_edits, read_judging
from wpcal.seam.options import Judging
from wpcal.weld.xmcf.read import places_of, read_xmcf


@dataclass(frozen=True, slots=True, kw_only=True)
class SeamsAsked:
    """What a person decides about the seams: edits of those found, and marked edges."""

    seams_file: Path | None = opt(
        None,
        "A seams.json of this part with decisions, from the picker, from the page of seams, or edited: an object edit "
        "with accept, reject, reverse, name, range_mm, other_side, join.",
        "--seams",
        metavar="FILE",
    )
    marked: tuple[str, ...] = opt(
        (),
        "Edges and wires of this name or layer (* and ? match any letters) or colour (#rrggbb) are the seams. With "
        "--marked or --edge nothing else is.",
        metavar="PATTERN",
        many=True,
    )
    edges: tuple[str, ...] = opt(
        (),
        "The edge at x,y,z (part frame, mm) or at a feature (M12) is a seam. With --edge or --marked nothing else is.",
        "--edge",
        metavar="PLACE",
        many=True,
    )
    added_edges: tuple[str, ...] = opt(
        (),
        "One seam more than those that are found: the edge at x,y,z (part frame, mm) or at a feature (M12).",
        "--add-edge",
        metavar="PLACE",
        many=True,
    )
    xmcf: Path | None = opt(
        None,
        "Welds of an xMCF file (ISO/PAS 8329, coordinates of the part): the edges at them are the seams. "
        "With it nothing else is.",
        metavar="WELDS.xml",
    )

    def to_choice(self) -> SeamChoice:
        """Return the choice; the files are read."""
        file = self.seams_file
        edits, judging = ((), Judging()) if file is None else (read_edits(file), read_judging(file))
        places = () if self.xmcf is None else places_of(read_xmcf(self.xmcf), file=str(self.xmcf))
        return SeamChoice(edits, self.marked, (*self.edges, *places), self.added_edges, judging)

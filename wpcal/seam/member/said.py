"""What a person says about members, on one part: inside which faces nothing is welded, and which corners are welds."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.errors import ErrorCode, InputError
from wpcal.seam.member.listed import Listed, list_members
from wpcal.seam.options import CAST, KINDS, STOCK, WELDMENT, Judging, SaidMember
from wpcal.seam.rules import Rule
from wpcal.seam.seam import Finding, SeamPieces

SAME_PLACE_MM = 0.1  #: A member is the one of which something was said if its middle is there within this.
MOST_NAMES = 5  #: Names of solids shown for a name that no member has.


@dataclass(slots=True, eq=False)
class Said:
    """What is said about the members of a part: sets of faces."""

    members: list[SaidMember] = field(default_factory=list)  #: With the places of the members.
    whole: dict[str, set[int]] = field(default_factory=dict)  #: Of what is one piece, by the words for it.
    #: By words: of what is not welded (`CAST`), was welded of pieces (`WELDMENT`), is welded to others (all else).
    faces: dict[str, set[int]] = field(default_factory=lambda: defaultdict(set))

    def against(self, pieces: SeamPieces) -> Iterator[Finding]:
        """Yield what is said against a candidate."""
        if not self.members:
            return
        both = np.array([pieces.wall, pieces.base])
        for words in [words for words, own in self.whole.items() if np.isin(both, list(own)).all()]:
            yield Rule.SAID_ONE.found(f"you said so (--member {words}): nothing is welded inside")
        if np.isin(both, list(self.faces[CAST])).any():
            yield Rule.SAID_NOT.found("you said that a member here is cast or bought: it is not welded")

    def are_joints(self, wall: IntArray, base: IntArray) -> BoolArray:
        """Tell which corners are said to be welds, shape (n,): round a piece of stock, or inside a weldment."""
        if not self.members:
            return np.zeros(len(wall), dtype=bool)
        both, stock = np.array([wall, base]), set().union(*(self.faces[word] for word in STOCK))
        found = np.isin(both, list(self.faces[WELDMENT])).all(axis=0) | np.isin(both, list(stock)).any(axis=0)
        for own in self.whole.values():
            found &= ~np.isin(both, list(own)).all(axis=0)
        return np.asarray(found)

    def add(self, said: SaidMember, faces: set[int]) -> None:
        """Add a statement about a member, or that two are one; also with those that are one with them already."""
        if said.word in KINDS:
            self.faces[said.word] |= faces
        if said.word != WELDMENT:
            names = [said.member, said.word]
            for words in [words for words in self.whole if said.word not in KINDS and {*names} & {*words.split("=")}]:
                names, faces = [*names, *words.split("=")], faces | self.whole.pop(words)
            self.whole["=".join(names)] = faces


def said_about(graph: BrepGraph, trimmed: TrimmedFaces, judging: Judging) -> Said:
    """Return what is said about the members of a part.

    Raises `InputError` if no member has a name, or the member is not where it was when something was said about it.
    """
    found = Said()
    for said in judging.members:
        one = _named(graph, trimmed, said)
        other = set[int]() if said.word in KINDS else _named(graph, trimmed, SaidMember(said.word, said.member)).faces
        found.members.append(replace(said, at_mm=one.centre_mm))
        found.add(said, {*one.faces, *other})
    return found


def _named(graph: BrepGraph, trimmed: TrimmedFaces, said: SaidMember) -> Listed:
    """Return the member about which something is said."""
    wanted = (said.member, said.member.rpartition("/")[0])
    own = [solid for solid, name in enumerate(graph.solid_names) if name in wanted]
    known = {one.name: one for solid in own for one in list_members(graph, trimmed, solid)}
    if (found := known.get(said.member)) is None:
        names = ", ".join(known or graph.solid_names[:MOST_NAMES])
        kinds = "" if said.word in KINDS else f" (and it is none of {', '.join(KINDS)})"
        text = f"no member has the name {said.member!r}{kinds}; there is {names}"
        raise InputError(text, code=ErrorCode.SOLID_UNKNOWN)
    if said.at_mm is not None and not np.allclose(found.centre_mm, said.at_mm, rtol=0.0, atol=SAME_PLACE_MM):
        places = "{:.1f}, {:.1f}, {:.1f} and not at {:.1f}, {:.1f}, {:.1f}".format(*found.centre_mm, *said.at_mm)
        text = f"member {said.member} is at {places}: the part has changed, or is another one"
        raise InputError(text, code=ErrorCode.SOLID_UNKNOWN)
    return found

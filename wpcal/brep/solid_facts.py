"""What a file says about a solid besides its shape: names above it, its colour, its material."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SolidFacts:
    """What a file says about one solid."""

    path: tuple[str, ...] = ()  #: Names of the instances from the root down, the solid's own last.
    products: tuple[str, ...] = ()  #: Names of the products from the root down, the solid's own last.
    color_rgb: tuple[float, float, float] | None = None  #: sRGB in 0…1.
    #: The material as written, with every text that belongs to it: ``S355J2``, ``Plywood, birch``.
    materials: tuple[str, ...] = ()
    density_kg_m3: float | None = None


def facts_of(facts: Sequence[SolidFacts], solid: int) -> SolidFacts:
    """Return what is known about a solid; nothing for a part without facts, such as one from a script."""
    return facts[solid] if solid < len(facts) else SolidFacts()

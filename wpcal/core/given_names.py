"""Names that a person gave, and names that a program gave because nobody else did."""

from __future__ import annotations

import re

_STEP = re.compile(
    r"((boss|base|cut)[ -])?(additive|subtractive|pad|pocket|chamfer|fillet|cut|fusion|union|common|boolean|body|solid|"
    r"shape|compound|component|extru(de|sion)|sweep|loft|revol(ve|ution)|mirror(ed)?|pattern|array|draft|thickness|"
    r"clone|copy|import(ed)?|feature|open cascade.*|s)[ _.:-]*\d*",
    re.IGNORECASE,
)
"""After the step that made a body: ``Pad001``, ``Cut``, ``Solid 3``."""
_LOST = re.compile(r"[\W\d_]*")
"""Without a letter: what is left of letters that an exporter could not write, as ``?????6``."""


def is_given_name(name: str) -> bool:
    """Tell whether a person gave a name: it is not that of a modelling step, and has letters.

    >>> [is_given_name(name) for name in ("left rail", "Pad001", "?????6", "Boss-Extrude2", "Bodywork")]
    [True, False, False, False, True]
    """
    return _STEP.fullmatch(name) is None and _LOST.fullmatch(name) is None

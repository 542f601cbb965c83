"""Words and numbers in names that tell what a solid is, in several languages (`words.toml`).

Words are written as they are, and compared without case and accents. ``-schraube`` stands for every word that ends so,
``шайб-`` for every word that begins so. A phrase of several words is written with underscores.
"""

import tomllib
from enum import Enum
from importlib.resources import files

HEAD_FIRST = frozenset({"fr", "es", "it", "pt", "pl", "ru"})
"""Languages in which the noun comes before what describes it: *support de moteur* is a support."""


class Kind(Enum):
    """What a solid is taken for, in words."""

    FASTENER = "a fastener"
    BEARING = "a bearing"
    GUIDE = "a linear guide or a ball screw"
    DRIVE = "a motor, a gearbox or a cylinder"
    SEAL = "a seal or a gasket"
    CABLE = "a cable, a hose, a belt or a chain"
    DEVICE = "an electric or optical device"
    SPRING = "a spring"
    WHEEL = "a tyre or a castor"
    WELD_NUT = "a nut or a stud to be welded"
    WOOD = "wood"
    PLASTIC = "plastic"
    RUBBER = "rubber"
    GLASS = "glass"
    SOFT = "foam, fabric or paper"
    STONE = "concrete or stone"
    STAINLESS = "stainless steel"
    STEEL = "steel"
    NICKEL = "a nickel alloy"
    ALUMINIUM = "aluminium"
    TITANIUM = "titanium"
    COPPER = "copper, brass or bronze"


NOT_METAL = frozenset({Kind.WOOD, Kind.PLASTIC, Kind.RUBBER, Kind.GLASS, Kind.SOFT, Kind.STONE})
METALS = frozenset({Kind.STAINLESS, Kind.STEEL, Kind.NICKEL, Kind.ALUMINIUM, Kind.TITANIUM, Kind.COPPER})
IRON = frozenset({Kind.STAINLESS, Kind.STEEL, Kind.NICKEL})  #: Metals that are welded to each other.

_DATA = tomllib.loads(files(__package__).joinpath("words.toml").read_text(encoding="utf-8"))

WORDS: dict[Kind, dict[str, str]] = {Kind[name]: languages for name, languages in _DATA["words"].items()}
"""Words by kind and language."""
MATERIAL_ONLY: dict[Kind, str] = {Kind[name]: words for name, words in _DATA["material_only"].items()}
"""Short words that tell something where a file says what the material is."""
STRUCTURE: str = _DATA["structure"]["last"]
STRUCTURE_FIRST: str = _DATA["structure"]["first"]
STRUCTURE_ENDS: tuple[str, ...] = tuple(_DATA["structure"]["ends"].split())
"""Nouns of steelwork; in languages in which the noun comes first; at the end of Chinese and Japanese names."""
FOR_MATERIAL = frozenset(_DATA["for_material"]["en"].split())  #: After a word for a material these say what it is for.
SIDES = frozenset(_DATA["sides"]["en"].split())  #: Words that follow the noun of a name.
STANDARDS: dict[Kind, dict[str, str]] = {Kind[name]: bodies for name, bodies in _DATA["standards"].items()}
"""Numbers of standards by kind and by the body that issued them."""
DENSITY_KG_M3: dict[Kind, float] = {Kind[name]: value for name, value in _DATA["density_kg_m3"].items()}
CODES: tuple[tuple[Kind, str], ...] = (
    (Kind.FASTENER, r"m(?:[2-9]|[1-3]\d|1\.6|2\.5)(?:x\d+(?:\.\d+)?){1,2}"),
    (Kind.BEARING, r"(?:6[0-3]\d|6[02389]\d\d|72\d\d|302\d\d|51[12]\d\d)(?:[ -]?(?:2rs1?|rs|zz|2z|llu|ddu))"),
    (Kind.BEARING, r"(?:ucp|ucf|ucfl|ucfc|uct|kfl|kp|snl|lm|lmk|lmf)\d{1,3}(?:uu|luu)?"),
    (Kind.GUIDE, r"(?:hgr|hgh|hgw|mgn|mgw|egr|egh|sbr|tbr|lmr|sfu|hsr|ssr)\d{1,4}[a-z]{0,3}"),
    (Kind.DRIVE, r"nema ?\d{2}"),
)
"""What a designation without words tells: ``M8x30``, ``6204-2RS``, ``HGR15``, ``NEMA 17``."""

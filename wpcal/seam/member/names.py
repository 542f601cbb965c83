"""What a name says about a solid: a standard part, a thing that is not welded, or the material of a member.

A name is cut into words. A word for a thing counts where the name is about that thing: *flange bolt* is a bolt, *bolt
flange* is a flange. A word for a material counts anywhere but before a word that says what it is for (*wood stove*).
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

from wpcal.seam.member.words import (
    CODES,
    FOR_MATERIAL,
    HEAD_FIRST,
    MATERIAL_ONLY,
    METALS,
    NOT_METAL,
    SIDES,
    STANDARDS,
    STRUCTURE,
    STRUCTURE_ENDS,
    STRUCTURE_FIRST,
    WORDS,
    Kind,
)

_CAMEL = re.compile(r"(?<=[a-zß-ÿа-я])(?=[A-ZÀ-ÞА-Я])|(?<=[A-Z])(?=[A-Z][a-z])")
_SPECIAL = str.maketrans({"ß": "ss", "ł": "l", "Ł": "L", "ø": "o", "Ø": "O", "æ": "ae", "ı": "i", "đ": "d"})
_NUMBER_AT_END = re.compile(r"\d+$")
_PREFIX = {
    "din": r"din ?(?:vde )?", "iso": r"(?:iso|jis b iso) ?", "en": r"en ?", "gb": r"gb ?t? ?", "jis": r"jis ?b ?",
    "uni": r"uni ?", "gost": r"(?:gost|гост) ?", "pn": r"pn ?m? ?", "ansi": r"ansi ?b ?", "asme": r"asme ?b ?",
}  # fmt: skip
"""How the number of a standard is introduced, in a folded text."""
ANYWHERE = frozenset({Kind.FASTENER, Kind.WELD_NUT, Kind.GUIDE})
"""Things whose word may be anywhere in a name without a noun of steelwork: ``Nut M8 hex``. Others are the last word:
an *engine hoist* is no engine."""
USED_FOR = frozenset({Kind.WOOD, Kind.GLASS, Kind.SOFT, Kind.STONE})
"""Materials of things for which something is made: a *glass holder* holds glass, a *plastic holder* is of plastic."""


@dataclass(frozen=True, slots=True)
class Hit:
    """What a name says."""

    kind: Kind
    word: str  #: The word, phrase or number that says so.
    is_standard: bool = False  #: Whether it is the number of a standard or a designation.


@dataclass(frozen=True, slots=True)
class _Word:
    """A word at tokens `first` to `last` of a name."""

    kind: Kind
    lang: str
    word: str
    first: int
    last: int


def fold(text: str) -> str:
    """Return a text as words in lower case without accents, separated by single blanks.

    >>> fold("HexNut_M8 (verzinkt)"), fold("Unterlegscheibe-Größe 2")
    ('hex nut m8 verzinkt', 'unterlegscheibe grosse 2')
    """
    split = _CAMEL.sub(" ", text.translate(_SPECIAL))
    plain = "".join(c for c in unicodedata.normalize("NFKD", split) if not unicodedata.combining(c))
    return " ".join("".join(c if c.isalnum() or c == "." else " " for c in plain.lower()).replace(". ", " ").split())


@lru_cache(maxsize=4096)
def read_name(name: str) -> tuple[Hit, ...]:
    """Return what a name says: the thing first, then the material.

    >>> [hit.kind.name for hit in read_name("flange bolt M8")], read_name("bolt flange")
    (['FASTENER'], ())
    >>> [(hit.kind.name, hit.word) for hit in read_name("Sechskantmutter DIN 934")]
    [('FASTENER', 'din 934')]
    """
    text = fold(name)
    tokens = text.split()
    is_structure = [_by_forms(_STRUCTURE, token) or _by_forms(_STRUCTURE_FIRST, token) for token in tokens]
    found = list(_words(tokens))
    things = [word for word in found if word.kind not in METALS | NOT_METAL and _is_about(word, tokens, is_structure)]
    standard = _standard(text, has_structure=any(is_structure))
    hits = [] if standard is None else [standard]
    if any(word.kind is Kind.WELD_NUT for word in things):
        hits = [Hit(Kind.WELD_NUT, next(word.word for word in things if word.kind is Kind.WELD_NUT))]
    elif standard is None and things:
        hits.append(Hit(things[0].kind, things[0].word))
    for group in (NOT_METAL, METALS):
        stuff = [word for word in found if word.kind in group and not _is_for(word, tokens)]
        hits += [Hit(word.kind, word.word) for word in stuff[:1]]
    return tuple(hits)


@lru_cache(maxsize=1024)
def read_material(text: str) -> Hit | None:
    """Return what a material is, from its name as a file writes it; None if no word is known.

    >>> read_material("S355J2+N").kind.value, read_material("Birke Sperrholz 12 mm").kind.value, read_material("X")
    ('steel', 'wood', None)
    """
    for kind, pattern in _NUMBERED:
        match = pattern.search(text)
        if match is not None:
            return Hit(kind, match.group())
    tokens = fold(text).split()
    found = [word for word in _words(tokens, short=True) if word.kind in METALS | NOT_METAL]
    if not found:
        return None
    first = min(found, key=lambda word: (word.kind not in NOT_METAL and word.kind is not Kind.STAINLESS, word.first))
    return Hit(first.kind, first.word)


def _is_about(word: _Word, tokens: list[str], is_structure: list[bool]) -> bool:
    """Tell whether a name is about the thing that one of its words names."""
    is_head = word.last == _head(tokens) if word.lang not in HEAD_FIRST else word.first == 0
    if _by_forms(_STRUCTURE_FIRST, tokens[0]) and word.first > 0:
        return False
    others = is_structure[: word.first] + is_structure[word.last + 1 :]
    if any(others) or tokens[-1].endswith(STRUCTURE_ENDS):
        return is_head and not tokens[-1].endswith(STRUCTURE_ENDS)
    return is_head or word.kind in ANYWHERE or word.lang in ("zh", "ja")


def _head(tokens: list[str]) -> int:
    """Return the number of the last word of a name that is not a code or a side; the last token if all are."""
    stems = [_NUMBER_AT_END.sub("", token) for token in tokens]
    nouns = [k for k, stem in enumerate(stems) if len(stem) > 1 and stem.isalpha() and stem not in SIDES]
    return nouns[-1] if nouns else len(tokens) - 1


def _is_for(word: _Word, tokens: list[str]) -> bool:
    """Tell whether a word for a material says what a thing is for."""
    return word.kind in USED_FOR and any(_singular(token) in FOR_MATERIAL for token in tokens[word.last + 1 :])


def _standard(text: str, *, has_structure: bool) -> Hit | None:
    for kind, pattern in _STANDARDS if has_structure else (*_STANDARDS, *_CODES):
        match = pattern.search(text)
        if match is not None:
            return Hit(kind, match.group().strip(), is_standard=True)
    return None


def _singular(token: str) -> str:
    """Return a token without the number that programs add, and without the s of a plural."""
    stem = _NUMBER_AT_END.sub("", token) or token
    return stem[:-1] if len(stem) > 3 and stem.endswith("s") and not stem.endswith("ss") else stem


def _forms(token: str) -> tuple[str, ...]:
    stem = _NUMBER_AT_END.sub("", token) or token
    return tuple(dict.fromkeys((token, stem, _singular(token), stem[:-2] if stem.endswith("es") else stem)))


def _by_forms(table: _Table, token: str) -> bool:
    forms = _forms(token)
    return any(form in table.exact for form in forms) or table.by_part(forms) is not None


def _words(tokens: list[str], *, short: bool = False) -> Iterator[_Word]:
    """Yield the known words of a name: phrases first, then in the order of the table, then of the name."""
    found = []
    for first, token in enumerate(tokens):
        forms = _forms(token)
        entries = [entry for form in forms for entry in _ALL.exact.get(form, ())]
        entries += [entry for form in forms for entry in _SHORT.exact.get(form, ()) if short]
        part = _ALL.by_part(forms)
        found += [_Word(kind, lang, token, first, first) for kind, lang in entries + ([] if part is None else [part])]
        phrases = (*_ALL.phrases.get(token, ()), *(_SHORT.phrases.get(token, ()) if short else ()))
        for phrase, kind, lang in phrases:
            last = first + len(phrase) - 1
            if last < len(tokens) and all(
                want in _forms(have) for want, have in zip(phrase, tokens[first : last + 1], strict=True)
            ):
                found.append(_Word(kind, lang, " ".join(phrase), first, last))
    yield from sorted(
        found, key=lambda word: (word.first - word.last, _ORDER[word.kind], word.lang not in HEAD_FIRST, word.first)
    )


@dataclass(frozen=True)
class _Table:
    """Words by how they are compared: whole, by their end, their begin or a part of them, and phrases."""

    exact: dict[str, list[tuple[Kind, str]]]
    suffixes: list[tuple[str, Kind, str]]
    prefixes: list[tuple[str, Kind, str]]
    parts: list[tuple[str, Kind, str]]
    phrases: dict[str, list[tuple[tuple[str, ...], Kind, str]]]

    @cached_property
    def _affixes(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return tuple(end for end, _, _ in self.suffixes), tuple(begin for begin, _, _ in self.prefixes)

    def by_part(self, forms: tuple[str, ...]) -> tuple[Kind, str] | None:
        """Return the kind and language of a word of which a token has the end, the begin or a part."""
        ends, begins = self._affixes  # most tokens have none
        for end, kind, lang in self.suffixes if any(form.endswith(ends) for form in forms) else ():
            if any(form.endswith(end) for form in forms):
                return kind, lang
        for begin, kind, lang in self.prefixes if any(form.startswith(begins) for form in forms) else ():
            if any(form.startswith(begin) for form in forms):
                return kind, lang
        for part, kind, lang in self.parts:
            if part in forms[0]:
                return kind, lang
        return None


def _table(rows: Iterator[tuple[str, Kind, str]]) -> _Table:
    table = _Table({}, [], [], [], {})
    for word, kind, lang in rows:
        plain = fold(word)
        if word.startswith("-"):
            table.suffixes.append((plain, kind, lang))
        elif word.endswith("-"):
            table.prefixes.append((plain, kind, lang))
        elif lang in ("zh", "ja"):
            table.parts.append((plain, kind, lang))
        elif "_" in word:
            phrase = tuple(plain.split())
            table.phrases.setdefault(phrase[0], []).append((phrase, kind, lang))
        else:
            table.exact.setdefault(plain, []).append((kind, lang))
    return table


_ALL = _table(
    (word, kind, lang)
    for kind, languages in WORDS.items()
    for lang, words in languages.items()
    for word in words.split()
)
_SHORT = _table((word, kind, "en") for kind, words in MATERIAL_ONLY.items() for word in words.split())
_STRUCTURE = _table((word, Kind.STEEL, "en") for word in STRUCTURE.split())
_STRUCTURE_FIRST = _table((word, Kind.STEEL, "fr") for word in STRUCTURE_FIRST.split())
_ORDER = {kind: number for number, kind in enumerate(WORDS)}


def _standard_pattern(body: str, numbers: str) -> re.Pattern[str]:
    any_number = "|".join(sorted(map(re.escape, numbers.split()), key=len, reverse=True))
    return re.compile(rf"(?:^|(?<= )){_PREFIX[body]}(?:{any_number})(?=$|[ .x]|[a-z])")


_STANDARDS = [
    (kind, _standard_pattern(body, numbers)) for kind, bodies in STANDARDS.items() for body, numbers in bodies.items()
]
_NUMBERED = (
    (Kind.STAINLESS, re.compile(r"\b1\.4\d{3}\b")),
    (Kind.STEEL, re.compile(r"\b1\.[0-35-8]\d{3}\b")),
    (Kind.NICKEL, re.compile(r"\b2\.4\d{3}\b")),
    (Kind.COPPER, re.compile(r"\b2\.[01]\d{3}\b")),
    (Kind.TITANIUM, re.compile(r"\b3\.7\d{3}\b")),
    (Kind.ALUMINIUM, re.compile(r"\b3\.[0-6]\d{3}\b|\bEN AW[ -]?\d{4}")),
)
"""Material numbers of EN 10027-2 and their like."""
_CODES = [(kind, re.compile(rf"(?:^|(?<= )){code}(?=$| )")) for kind, code in CODES]

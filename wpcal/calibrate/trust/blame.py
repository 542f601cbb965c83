"""What the observations say about a wrong one among them: which, how sure, and which feature it was touched on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from wpcal.calibrate.trust.tool_offset import ToolOffset
from wpcal.core.issue import Issue
from wpcal.core.wording import plural, short

MOST_LISTED = 6  #: Most names in a sentence; the issue's ids have the rest.


@dataclass(frozen=True, slots=True)
class Exchange:
    """A point that fits if it was touched on another feature than its row says."""

    name: str  #: Of the row.
    feature: str  #: The feature it was probably touched on.
    instead_of: str  #: The feature of the row; empty if its place is no feature.
    largest_mm: float  #: Largest residual of the least-squares fit with the other feature.

    @property
    def sentence(self) -> str:
        """What was found and what to do."""
        row = "" if self.name == self.instead_of else f"{self.name}: "
        now = self.instead_of or "the feature of its row"
        return f"{row}{self.feature} instead of {now} leaves {self.largest_mm:.2g} mm; was {self.feature} touched?"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "name": self.name,
            "feature": self.feature,
            "instead_of": self.instead_of or None,
            "largest_mm": self.largest_mm,
        }


@dataclass(frozen=True, slots=True)
class Suspect:
    """The observations that the evidence names as wrong, or how many are wrong if it names none."""

    names: tuple[str, ...]  #: Empty if no set of observations is probable enough.
    off_mm: tuple[float, ...]  #: How far each of them lies from the fit of the others.
    #: Of these names, if as many are wrong and all sets were equally likely before. None if none is named.
    probability: float | None
    at_least: int  #: The least number of wrong observations.
    #: Other sets that may be the wrong ones, with their probabilities.
    rivals: tuple[tuple[tuple[str, ...], float], ...] = ()
    exchanges: tuple[Exchange, ...] = ()  #: Observations that fit if they were touched on another feature.
    word: str = "point"  #: What one observation is called.
    body: str = ""  #: The body that explains them if it stands elsewhere than in the model; they are all on it.

    @property
    def sentence(self) -> str:
        """Say who is suspected, how far off, and how sure that is."""
        if self.body:
            return (
                f"{self.body} stands elsewhere than in the model, by up to {short(max(self.off_mm))} mm at its "
                f"{len(self.names)} {plural(self.word)}, and all others agree: let its tacks move (--bodies), or take "
                "the model of this revision"
            )
        if self.exchanges:
            return "; ".join(exchange.sentence for exchange in self.exchanges)
        if not self.names:
            return self._unnamed()
        pairs = list(zip(self.names, self.off_mm, strict=True))
        listed = ", ".join(f"{name} ({short(off)} mm off their fit)" for name, off in pairs[:MOST_LISTED])
        more = f" and {len(pairs) - MOST_LISTED} more" if len(pairs) > MOST_LISTED else ""
        return f"the other {plural(self.word)} contradict {listed}{more}{self._sureness()}"

    def _sureness(self) -> str:
        if self.probability is None:
            return ""
        rest = "".join(f"; {' and '.join(names)} {_percent(p)}" for names, p in self.rivals[:2] if p >= 0.02)
        return f", probability {_percent(self.probability)}{rest}"

    def _unnamed(self) -> str:
        if self.at_least > 1 and not self.rivals:
            return f"two or more {plural(self.word)} are wrong, and the data cannot tell which"
        listed = " or ".join(f"{' and '.join(names)} ({_percent(p)})" for names, p in self.rivals[:4])
        if not listed:
            return f"a {self.word} is wrong, and the data cannot tell which"
        count = f"one {self.word} is" if self.at_least == 1 else f"{self.at_least} {plural(self.word)} are"
        return f"{count} wrong, and the data cannot tell which: {listed}"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "names": list(self.names),
            "off_mm": list(self.off_mm),
            "probability": self.probability,
            "at_least": self.at_least,
            "rivals": [{"names": list(names), "probability": p} for names, p in self.rivals],
            **({"body": self.body} if self.body else {}),
            "exchanges": [exchange.to_record() for exchange in self.exchanges],
            "sentence": self.sentence,
        }


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What is wrong with observations."""

    issues: tuple[Issue, ...]
    suspect: Suspect | None = None  #: None if no observation is contradicted.
    tool: ToolOffset | None = None  #: None if the postures of the tool do not show an error of its centre point.


def _percent(probability: float) -> str:
    return "above 99 %" if probability > 0.99 else f"{100.0 * probability:.0f} %"

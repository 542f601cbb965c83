"""Answers about a part that stay in memory while the part is open, in front of those that are kept in files."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from cad.workpiece.answer_cache import AnswerCache, key_of

MOST_ANSWERS = 8  #: Of one part: its faces, triangles, and the seams with the last options.

Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class WarmAnswers(AnswerCache):
    """A cache whose last answers are in memory. `folder`, `most_mb`, `kernel`: As for `AnswerCache`."""

    _memory: OrderedDict[str, Any] = field(default_factory=OrderedDict, compare=False, repr=False)

    @classmethod
    def before(cls, cache: AnswerCache) -> WarmAnswers:
        """Return a memory in front of a cache."""
        return cls(cache.folder, cache.most_mb, cache.kernel)

    def answer(self, what: str, of: Sequence[object], make: Callable[[], Answer]) -> Answer:
        """Return an answer from memory or from its file, or find it; parameters as in `AnswerCache.answer`."""
        key = key_of(what, of)
        if key not in self._memory:
            self._memory[key] = AnswerCache.answer(self, what, of, make)
            if len(self._memory) > MOST_ANSWERS:
                self._memory.popitem(last=False)
        self._memory.move_to_end(key)
        found: Answer = self._memory[key]
        return found

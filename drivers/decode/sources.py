"""From the frames of a message to the readings of a channel or input, with all that is unusable left out by reason."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drivers.decode.dbc import Bits, Condition, Dbc, Layout, Words
from drivers.frames import Array, Mask, Tally, Whole
from estimator.errors import SetupError
from estimator.rig import Rig, Signal

# Texts of a state that say that a reading is wrong; others say which reading it is.
_FAULT = re.compile(
    r"avail|n/a|fault|err|valid|no.?(data|value|signal)|undef|reserved|unknown|range|over|under|low|high|short|open|wire"
    r"|bad|fail|alarm|warn|satur|lost|time.?out",
    re.IGNORECASE,
)


@dataclass
class Source:
    """Where a channel or input comes from: its signals are added up, then scaled as the rig file says."""

    name: str
    rule: Signal
    message: Layout
    parts: tuple[Bits, ...]
    fresh: Bits | None = None
    valid: Condition | None = None
    held: int | None = None  # last value of `fresh`

    def read(self, words: Words, now: Array, quiet_s: float, tally: Tally) -> tuple[Mask, Array]:
        """Readings of the frames of its message: where there is one, (n,) bool, and all values, (n,).

        now      (n,) s since the log's first frame
        quiet_s  a `fresh` number first seen later than this came with its reading; sooner, it may be long held
        """
        raws = [bits.raw(words) for bits in self.parts]
        total = sum((bits.physical(raw) for bits, raw in zip(self.parts, raws, strict=True)), np.zeros(len(now)))
        value = self.rule.scale * total + self.rule.offset
        use = np.logical_and.reduce([bits.present(words) for bits in self.parts])
        if self.fresh:
            use &= self._fresh(self.fresh.raw(words).astype(np.int64), now, quiet_s, tally)
        for bits, raw in zip(self.parts, raws, strict=True):
            for number, text in bits.no_value.items():
                use = self._drop(use, raw == number, text, tally)
        if self.valid:
            for text, wrong in self.valid.broken(words, f"unknown {self.valid.bits.name}"):
                if _FAULT.search(text):
                    use = self._drop(use, wrong, f"flagged {text}", tally)
                else:
                    tally.skip(f"other state {text} {self.name}", np.count_nonzero(use & wrong))
                    use &= ~wrong
        use = self._drop(use, ~np.isfinite(value), "no number", tally)
        with np.errstate(invalid="ignore"):
            use = self._drop(use, (value < self.rule.lo) | (value > self.rule.hi), "out of range", tally)
        return use, value

    def _fresh(self, number: Whole, now: Array, quiet_s: float, tally: Tally) -> Mask:
        if not len(number):
            return np.zeros(0, bool)
        new: Mask = np.diff(number, prepend=number[0] if self.held is None else self.held) != 0
        if self.held is None:
            new[0] = now[0] > quiet_s
            tally.skip(f"held since before the log {self.name}", int(not new[0]))
        self.held = int(number[-1])
        return new

    def _drop(self, use: Mask, bad: Mask, reason: str, tally: Tally) -> Mask:
        tally.refuse(reason, self.name, np.count_nonzero(use & bad))
        return use & ~bad


def sources(rig: Rig, dbc: Dbc) -> Iterator[Source]:
    """A source for each channel and input of the rig that has a signal; one that the DBC lacks is a SetupError."""
    for table, rules in (("channels", rig.channels), ("inputs", rig.inputs)):
        for name, rule in rules.items():
            key = f"{rig.folder / 'rig.toml'}: {table}.{name}"
            if rule.signals:
                yield _source(name, rule, dbc, key)
            elif rule.column is None:
                raise SetupError(f"{key}: 'signal' is missing: which signal of {dbc.path.name} is it?")


def _source(name: str, rule: Signal, dbc: Dbc, key: str) -> Source:
    pairs = [dbc.signal(dotted, f"{key}.signal") for dotted in rule.signals]
    message = pairs[0][0]
    fresh = dbc.signal(rule.fresh, f"{key}.fresh") if rule.fresh else None
    valid = dbc.condition(rule.valid, f"{key}.valid") if rule.valid else None
    asked = [*pairs, fresh] if fresh else pairs
    for other in [m.name for m, _ in asked] + ([valid.message] if valid else []):
        if other != message.name:
            raise SetupError(f"{key}: {other} and {message.name} are two messages; a reading comes from one")
    return Source(name, rule, message, tuple(bits for _, bits in pairs), fresh[1] if fresh else None, valid)

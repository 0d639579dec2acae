"""Whether a model is this machine's, in a line that names the next command, and for programs."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ballscrew.workspace import Loaded, Workspace
from estimator.accuracy.machine import LIMIT_SD, Match
from estimator.model import Model


@dataclass(frozen=True)
class MachineVerdict:
    """What a match means; nothing is said, and no command named, where the model does as well as it says.

    loaded  the recordings of the match, in its order
    """

    work: Workspace
    model: Model
    match: Match
    loaded: Sequence[Loaded]

    @property
    def sentence(self) -> str:
        """What is said of the model, and the next command; "" for nothing."""
        if not self._apart:
            return ""
        off_sd = np.median([self.match.off_sd[i] for i in self.match.apart])
        off = f"alone it is {off_sd:.1f} times as far off as its parameters, noise and sensors allow"
        if self.match.own:
            names = ", ".join(one.path.name for one in self._apart)
            return f"{self.model.name} does not follow {names}, but the others: {off} there; see where: `{self.next}`"
        if self._was_fitted:
            return f"{self.model.name} lacks something: fitted to these recordings, {off}; see where: `{self.next}`"
        if self._added:
            return (
                f"{self.model.name} is not fitted since {', '.join(self._added)} came in: {off}; fit it: `{self.next}`"
            )
        return f"{self.model.name} is not this machine's: {off}; fit it: `{self.next}`"

    @property
    def next(self) -> str:
        """The command to give next; "" for none."""
        if not self._apart:
            return ""
        if self.match.own:
            return self._command("diagnose", [one.path for one in self._apart])
        return self._command("diagnose") if self._was_fitted else self._command("fit", out="fitted.toml")

    def as_json(self) -> dict[str, Any]:
        """The verdict for programs."""
        off_sd = [{"name": one.recording.name, "off_sd": sd} for one, sd in zip(self.loaded, self.match.off_sd)]
        return {
            "own": self.match.own, "recordings": off_sd, "limit_sd": LIMIT_SD,
            "sentence": self.sentence or None, "next": self.next or None,
        }  # fmt: skip

    @property
    def _apart(self) -> list[Loaded]:
        return [self.loaded[i] for i in self.match.apart]

    @property
    def _was_fitted(self) -> bool:
        known = set(self.model.about.get("fitted_on", {}).values())
        return not self._added and all(one.recording.fingerprint in known for one in self._apart)

    @property
    def _added(self) -> list[str]:
        """Effects of which no fit knows a parameter that it may change, where one knows others."""
        fitted = self.model.about.get("covariance", {}).get("paths", [])
        return sorted({path.split(".")[0] for path in self.model.free() if path not in fitted}) if fitted else []

    def _command(self, verb: str, logs: Sequence[Path] = (), out: str = "") -> str:
        words = ["ballscrew", verb, *(logs or self.work.logs)]
        words += ["--rig", self.work.rig_path] if self.work.rig_path else []
        words += ["--model", (self.model.folder or Path()) / self.model.name, *(["-o", out] if out else [])]
        return shlex.join(map(str, words))

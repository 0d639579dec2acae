"""An effect as a command line names it: by its name in the catalogue, or as FILE.py or FILE.py:Class of one's own."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from ballscrew.own_effect.patience import patience
from estimator.effect import Effect
from estimator.effects import CATALOGUE
from estimator.errors import SetupError, nearest
from estimator.model import Model, file_and_class
from estimator.rig_folder.model_toml import own_effect, own_effects


@dataclass(frozen=True)
class Named:
    """An effect; `file` is where one of the user's own is, seen from the working directory."""

    effect: type[Effect]
    file: Path | None = None

    @property
    def use(self) -> str:
        """As a command line names it."""
        return f"{self.file}:{self.effect.__name__}" if self.file else self.effect.name

    def used_by(self, model: Model) -> Model:
        """A model that has the effect, with the file of one's own kept as seen from the model's folder."""
        if self.file is None:
            return model
        assert model.folder is not None
        file = Path(os.path.relpath(self.file, model.folder)).as_posix()
        return replace(model, use={**model.use, self.effect.name: f"{file}:{self.effect.__name__}"})


def named_effects(word: str) -> list[Named]:
    """The effects that a word means; a FILE.py runs as code, and means all that are written in it."""
    file, cls = file_and_class(word)
    if not file.endswith(".py"):
        if word not in CATALOGUE:
            raise SetupError(f"no effect '{word}' in the catalogue; {nearest(word, CATALOGUE)}")
        return [Named(CATALOGUE[word])]
    path = Path(file)
    if not path.is_file():
        raise SetupError(f"{path}: no such effect file")
    with patience(path):
        if cls:
            return [Named(own_effect(word, Path()), path)]
        found = [Named(effect, path) for effect in own_effects(path).values() if effect.__module__ == path.stem]
    if not found:
        raise SetupError(f"{path}: no effect in it; write a class that is an Effect, or ballscrew new-effect NAME")
    return found


def named_effect(word: str) -> Named:
    """The one effect that a word means."""
    found = named_effects(word)
    if len(found) > 1:
        raise SetupError(f"{word} has {len(found)} effects; name one of them: {', '.join(one.use for one in found)}")
    return found[0]

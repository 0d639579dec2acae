"""Thermal elongation of a ball screw: the public face, and the `ballscrew` command, one file for each of its commands.

    rig, model = load_rig("recordings"), load_model("recordings/model.toml")
    recording = read("FS-20.log", rig)
    review(recording, rig, model)              what the filter, the smoother and the model alone make of it
    fit(model, Runs(rig, [recording]))         likewise tune, compare, diagnose and events
    suggest(model, Runs(rig, [recording]), CATALOGUE.values())
    improve(model, Runs(rig, [recording]), Runs(rig, held_out), CATALOGUE.values())
    step = Filter(model, rig).step(sample)     tick by tick, for sample in recording
    class CoolantJet(Effect): ...              physics of your own, its numbers each a Param

Each name is imported when it is used. The command begins in cli, and shares workspace, reviewing, search, machine,
began, at_a_glance, options, completion, muting and terminal; then commands/, report/, page/, table/, monitor/,
fleet/, workers/, new_rig/, doubts/ and own_effect/.
"""

from importlib import import_module
from typing import Any

_HOMES = {
    "CATALOGUE": "estimator.effects",
    "Effect": "estimator.effect",
    "Filter": "estimator.filter",
    "Param": "estimator.effect",
    "Runs": "estimator.work",
    "compare": "estimator.accuracy.compare",
    "diagnose": "estimator.missing_heat.diagnose",
    "events": "estimator.events.events",
    "fit": "estimator.fit.fit",
    "improve": "estimator.missing_effect.improve",
    "load_model": "estimator.rig_folder.model_toml",
    "load_rig": "estimator.rig_folder.rig_folder",
    "read": "drivers.recordings",
    "review": "estimator.accuracy.review",
    "suggest": "estimator.missing_effect.suggest",
    "tune": "estimator.fit.tune",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("ballscrew")
    if name not in _HOMES:
        raise AttributeError(f"module 'ballscrew' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), "read_recording" if name == "read" else name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]

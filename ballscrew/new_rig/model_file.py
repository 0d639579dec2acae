"""A first model.toml: the effects of the catalogue that the rig can have, heaters and bodies as effects of its own."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ballscrew.new_rig.seen import Guess
from ballscrew.new_rig.temperatures import THERMOMETER
from ballscrew.own_effect.class_file import HEAD, with_class
from drivers.frames import Array
from estimator.effect import Effect
from estimator.effects import CATALOGUE
from estimator.inputs.follower import known_followers
from estimator.model import Model
from estimator.rig import Rig
from estimator.rig_folder.model_toml import own_effects, save_model
from estimator.unknown.effect_text import VOCABULARY, Wanted, effect_text

EFFECTS = "effects.py"
LOSS = "loss"
ROOM_MM = 2000.0
CAPACITY = 50.0  # of a body, J/K: what else is fitted is in proportion to it
MEDIAN = 0.6745  # of what is spread normally, of the absolute values, in sd
ROUNDING_K = 1e-6
OF_BODIES = {**VOCABULARY, "Store": "estimator.terms", "combinations": "itertools"}
_PARTS = 100  # of a recording, over which a heater warms what is beside it
_BODIES = '''class Bodies(Effect):
    """The bodies store heat, and lose it to the air.

    C dT/dt = sum of the heats - g (T - T_air)
    """

    capacity = Param(50.0, "J/K", lo=0.1, hi=1e5, fixed=True, source="guessed: weigh them; 450 J/K for a kg of steel")
    g = Param(0.2, "W/K", lo=0.0, hi=100.0, source="guessed: 10 W/(m2 K) on 0.02 m2; a fit finds it")
    noise = Param(0.1, "W/sqrt(Hz)", lo=1e-5, hi=100.0, fixed=True, source="guessed: draughts")

    def terms(self, p, u, rig):
        for body in rig.bodies:
            yield Store(body, p.capacity, p.noise)
            yield Link(body, "ambient", p.g)
'''
_UNUSED = {  # classes that no model has yet, and how many bodies they need: `suggest` tries what stands in the file
    """class Coupling(Effect):
    \"\"\"The bodies warm each other. In no model yet: `ballscrew suggest` tries it.

    q = g (T_one - T_other), of any two
    \"\"\"

    g = Param(0.02, "W/K", lo=0.0, hi=100.0, null=0.0, source="guessed: air and what they stand on between them")

    def terms(self, p, u, rig):
        for one, other in combinations(rig.bodies, 2):
            yield Link(one, other, p.g)
""": 2,
    """class Inside(Effect):
    \"\"\"Something in each body, or beside it, stores heat too. In no model yet: `ballscrew suggest` tries it.

    C dT/dt = g (T_body - T)
    \"\"\"

    capacity = Param(20.0, "J/K", lo=0.1, hi=1e5, source="guessed: less than the body")
    g = Param(0.1, "W/K", lo=0.0, hi=100.0, null=0.0, source="guessed: a fit finds it")

    def terms(self, p, u, rig):
        for body in rig.bodies:
            yield Store(f"in_{body}", p.capacity, 1e-6)
            yield Link(body, f"in_{body}", p.g)
""": 1,
}


def write_model(rig: Rig, guesses: Sequence[Guess], folder: Path) -> None:
    """Write model.toml, and effects.py where the catalogue has no effect for what the rig has."""
    model = Model({}, {}, name="model.toml", folder=folder)
    text = HEAD
    if not rig.screw:
        text = with_class(text, _BODIES, OF_BODIES, folder / EFFECTS)
    for guess in guesses:
        if guess.role == "heater":
            text = with_class(text, _heater(guess, guesses, rig), VOCABULARY, folder / EFFECTS)
    own = {}
    if text != HEAD:
        (folder / EFFECTS).write_text(text, encoding="utf-8")
        own = own_effects(folder / EFFECTS)
        _write_unused(rig, text, folder / EFFECTS)
    for effect in [CATALOGUE[name] for name in of_the_catalogue(rig)] + list(own.values()):
        model = model + effect
    guessed = dict(_powers(rig, guesses, own))
    for path, value in [*guessed.items(), ("thermometers.sd", _scatter_K(guesses))]:
        param = model.param(path)
        model = model.with_values({path: min(max(value, param.lo), param.hi)})
    unsure = {path: replace(model.values[path], sd=abs(model[path])) for path in guessed}  # by as much as itself
    model = replace(model, values={**model.values, **unsure})
    model = replace(model, use={effect.name: f"{EFFECTS}:{cls}" for cls, effect in own.items()})
    save_model(model, folder / "model.toml")


def _write_unused(rig: Rig, text: str, path: Path) -> None:
    """Write what the bodies may lack below what the model has."""
    for added, bodies in _UNUSED.items():
        if not rig.screw and len(rig.bodies) >= bodies:
            text = with_class(text, added, OF_BODIES, path)
    path.write_text(text, encoding="utf-8")


def of_the_catalogue(rig: Rig) -> Iterator[str]:
    """Names of the effects whose parts and inputs this rig has; each at the values of its table."""
    if rig.screw:
        yield from ("conduction", "still_air")
        if "speed" in rig.inputs:
            yield "rotating_convection"
    if rig.nut:
        yield from ("nut_friction", "nut_body")
    if rig.supports and "speed" in rig.inputs:
        yield from ("anchor_friction", "anchor_housing", "free_friction", "free_housing")
    yield "thermometers"
    if rig.screw and "displacement" in rig.channels:
        yield "displacement"


def _powers(rig: Rig, guesses: Sequence[Guess], own: Mapping[str, type[Effect]]) -> Iterator[tuple[str, float]]:
    """First values of the effects of its own: a W is a W on a rod; bodies as they warmed and cooled."""
    rates = warmed(guesses)
    for guess in guesses:
        if guess.role == "heater" and rig.screw is None:
            yield f"{own[_class_of(guess)].name}.power", float(f"{CAPACITY * max(rates[guess.name].values()):.2g}")
        elif guess.role == "heater" and guess.rule.unit == "W":
            yield f"{own[_class_of(guess)].name}.power", 1.0
    if rig.screw is None:
        yield "bodies.g", float(f"{CAPACITY * max(float(np.mean([*rates[LOSS].values()])), 1e-3):.2g}")


def _scatter_K(guesses: Sequence[Guess]) -> float:
    """sd of a thermometer's reading, K: of how it leaves a line through the two beside it, or of a step of its digits.

    It is the median thermometer's, and no less than the table says.
    """
    found = [CATALOGUE["thermometers"].params["sd"].value]
    for value in (one.value for one in guesses if one.role == THERMOMETER and np.ptp(one.value)):
        steps = np.abs(np.diff(value))
        off = np.median(np.abs(np.diff(value, 2))) / MEDIAN / np.sqrt(6.0) if len(value) > 2 else 0.0
        found.append(max(off, steps[steps > ROUNDING_K].min(initial=np.inf) / np.sqrt(12.0)))
    return max(found[0], float(f"{np.median(found[1:]):.2g}")) if found[1:] else found[0]


def _heater(guess: Guess, guesses: Sequence[Guess], rig: Rig) -> str:
    """A heater as an effect: at the thermometer that it warms most."""
    channel = rig.channels[max(warmed(guesses)[guess.name].items(), key=lambda one: one[1])[0]]
    place = {"node": channel.node} if channel.node else {"at_mm": channel.at_mm}
    follows, name = known_followers(rig)[guess.name], json.dumps(guess.name)
    on = replace(follows, symbol=f" {guess.name}", formula=f"u[{name}]")  # a recording may begin with it just put on
    return effect_text(Wanted(_class_of(guess), on, **place), _longer(rig))


def _longer(rig: Rig) -> Rig:
    """The rig with room beyond the screw's ends, which are still to be edited."""
    screw = rig.screw
    return replace(rig, screw=screw and replace(screw, from_mm=screw.from_mm - ROOM_MM, to_mm=screw.to_mm + ROOM_MM))


def _class_of(guess: Guess) -> str:
    """The name of its effect's class, which no other has."""
    cls = "".join(word[:1].upper() + word[1:] for word in guess.name.split("_"))
    taken = {*OF_BODIES, "Bodies", "Coupling", "Inside", *(effect.__name__ for effect in CATALOGUE.values())}
    return f"{cls}Power" if cls in taken else cls


def warmed(guesses: Sequence[Guess]) -> dict[str, dict[str, float]]:
    """By how much each heater warms each thermometer, K/s for one of its unit; of `LOSS` how fast it cools, 1/s.

    dT/dt = sum of k_h P_h - (T - T(0)) / tau, least squares over parts of the recording
    """
    heaters = [one for one in guesses if one.role == "heater"]
    names = [*(one.name for one in heaters), LOSS]
    rates = {one.name: _rates(one, heaters) for one in guesses if one.role == THERMOMETER}
    return {name: {key: float(of[k]) for key, of in rates.items()} for k, name in enumerate(names)}


def _rates(one: Guess, heaters: Sequence[Guess]) -> Array:
    """Those of one thermometer, (heaters + 1,); 0 for one that was read once."""
    if not np.ptp(one.time):
        return np.zeros(len(heaters) + 1)
    at = np.linspace(one.time[0], one.time[-1], _PARTS + 1)
    value, middle = np.interp(at, one.time, one.value), (at[1:] + at[:-1]) / 2
    terms = [np.interp(middle, heater.time, heater.value) for heater in heaters]
    terms.append(value[0] - np.interp(middle, one.time, one.value))
    rates, *_ = np.linalg.lstsq(np.stack(terms, axis=1), np.diff(value) / np.diff(at))
    return np.asarray(rates)

"""ballscrew new-effect: write an effect of your own into a file, ready to be changed."""

import re
from pathlib import Path

import click

from ballscrew.completion import followers, words
from ballscrew.options import output_file, rig_option, terminal_options
from ballscrew.own_effect.class_file import HEAD, with_class
from ballscrew.own_effect.composed_file import text_in
from ballscrew.terminal import Terminal
from ballscrew.workspace import open_rig
from estimator.effects import CATALOGUE
from estimator.errors import SetupError, nearest
from estimator.inputs.follower import LOSSES, NAMES, Follower, known_followers
from estimator.rig import Rig
from estimator.unknown.effect_text import ALL, VOCABULARY, Wanted, effect_text

UNDER_NUT = "under-nut"


@click.command("new-effect")
@click.argument("name")
@click.option(
    "--at", metavar="350mm|BODY|under-nut",
    help="Heat around this place, into this body, or into what the nut covers; default: all along the screw.",
)  # fmt: skip
@click.option(
    "--follows", default="always", metavar="WORD", shell_complete=words(followers),
    help=f"{', '.join(NAMES)}, or an input of the rig, of which it follows the rise; default: always.",
)  # fmt: skip
@click.option("--reading", metavar="CHANNEL|all", help="Shift this channel's readings, or all thermometers', not heat.")
@output_file(
    "-o", "out", default=Path("effects.py"), metavar="FILE.py",
    help="Write it into this file, after what is there; default: effects.py.",
)  # fmt: skip
@rig_option("Rig folder; else the nearest one at or above the file, else the built-in rig.")
@terminal_options
def command(
    terminal: Terminal, name: str, at: str | None, follows: str, reading: str | None, out: Path, rig_path: Path | None
) -> None:
    """Write the effect NAME: a class with its equation, its parameters and its terms, which passes all checks as it is.

    Then change it: its numbers are guesses.
    """
    rig = open_rig([out], rig_path, terminal)
    if reading is not None and follows in [loss.name for loss in LOSSES]:
        raise SetupError(f"--follows {follows}: heat that goes to the air; a reading may follow the drive, say")
    cls, place = _class_name(name), _place(at, reading, rig)
    wanted = Wanted(cls, _follower(follows, rig), *place, reading=_channel(reading, rig))
    text = text_in(out) or HEAD
    out.write_text(with_class(text, effect_text(wanted, rig), VOCABULARY, out), encoding="utf-8")
    use = f"{out}:{wanted.cls}"
    terminal.say(f"{out}: {wanted.cls} written; its numbers are guesses: put in yours, and say where they come from")
    terminal.say(f"next: ballscrew effects {use} --check")
    terminal.say(f"      ballscrew add {use} model.toml -o better.toml")
    terminal.json({"file": str(out), "class": wanted.cls, "use": use})


def _class_name(name: str) -> str:
    """NAME in CamelCase: coolant_jet, coolant-jet and "coolant jet" are CoolantJet."""
    cls = "".join(word[:1].upper() + word[1:] for word in re.split(r"[\W_]+", name))
    if not (cls.isidentifier() and cls.isascii()) or cls in (*VOCABULARY, "True", "False", "None"):
        raise SetupError(f"'{name}' cannot be an effect's name; take words of letters, such as coolant_jet")
    if cls in {effect.__name__ for effect in CATALOGUE.values()}:
        raise SetupError(f"the catalogue has an effect '{name}' already; choose another name")
    return cls


def _place(at: str | None, reading: str | None, rig: Rig) -> tuple[float | None, str | None, bool]:
    """A place in mm, a body, or whether it is under the nut; none of them: all along the screw."""
    known = ", ".join(rig.bodies)
    if at is None:
        if rig.screw is None and reading is None:
            raise SetupError(f"{rig.name} has no screw; say with --at which body is heated: {known}")
        return None, None, False
    if reading is not None:
        raise SetupError("--at is where heat goes, --reading shifts a reading: leave one of them out")
    if at in rig.bodies:
        return None, at, False
    if at == UNDER_NUT:
        rig.the_nut()
        return None, None, True
    if rig.screw is None:
        raise SetupError(f"--at {at}: {rig.name} has no screw, and no thermometer in such a body; known: {known}")
    number = re.fullmatch(r"([-+]?\d+(?:\.\d*)?) ?(?:mm)?", at.strip())
    if not number:
        others = ", ".join((UNDER_NUT, *rig.bodies))
        raise SetupError(f"--at {at}: write a place in mm, such as 350mm, or one of: {others}")
    place, screw = float(number[1]), rig.the_screw()
    if not screw.from_mm <= place <= screw.to_mm:
        raise SetupError(f"--at {at}: outside the screw, {screw.from_mm:g} ... {screw.to_mm:g} mm")
    return place, None, False


def _follower(word: str, rig: Rig) -> Follower:
    known = known_followers(rig)
    if word not in known and word in NAMES:
        fast = "speed" in rig.inputs
        lacks = "screw that says which speed is fast" if fast else "input 'speed', so that nothing ever moves"
        raise SetupError(f"--follows {word}: {rig.name} has no {lacks}")
    if word not in known:
        raise SetupError(f"--follows {word}: neither known nor an input of {rig.name}; {nearest(word, known)}")
    return known[word]


def _channel(reading: str | None, rig: Rig) -> str | None:
    known = (ALL, *rig.channels)
    if reading is not None and reading not in known:
        raise SetupError(f"--reading {reading}: {rig.name} has no such channel; {nearest(reading, known)}")
    return reading

"""What a shell completes, beside commands, options and files: effects, experiments, and channels of the rig."""

from collections.abc import Callable, Iterable
from contextlib import redirect_stderr, suppress
from io import StringIO
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from estimator.errors import BallscrewError

Names = Callable[[click.Context], Iterable[str]]
Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def words(names: Names, or_file: bool = False, listed: bool = False) -> Complete:
    """What completes one of these names, which are imported when they are asked for.

    or_file  a file where no name begins so      listed  the last of several words with commas between
    """

    def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        before, comma, last = incomplete.rpartition(",") if listed else ("", "", incomplete)
        found = [CompletionItem(before + comma + name) for name in names(ctx) if name.startswith(last)]
        return found or [CompletionItem(incomplete, type="file")] * or_file

    return complete


def effect_names(ctx: click.Context) -> Iterable[str]:
    """The catalogue."""
    from estimator.effects import CATALOGUE

    return CATALOGUE


def followers(ctx: click.Context) -> Iterable[str]:
    """What an effect may follow on any rig."""
    from estimator.inputs.follower import NAMES

    return NAMES


def experiments(ctx: click.Context) -> Iterable[str]:
    """Those with a name; other speeds may follow a pattern."""
    from drivers.virtual_rig import EXPERIMENTS

    return EXPERIMENTS


def plants(ctx: click.Context) -> Iterable[str]:
    """Effects that the virtual rig can show."""
    from drivers.virtual_rig.machine.planted import BASE, PLANTED

    return [*PLANTED, *BASE]


def thermometers(ctx: click.Context) -> list[str]:
    """Thermometers of the rig that the words so far name; none where it cannot be read: a shell wants no message."""
    from ballscrew.terminal import Terminal
    from ballscrew.workspace import open_rig

    paths = [Path(log) for log in ctx.params.get("logs") or ()]
    with redirect_stderr(StringIO()), suppress(BallscrewError):
        return list(open_rig(paths, ctx.params.get("rig_path"), Terminal(quiet=True)).thermometers)
    return []


def mutes(ctx: click.Context) -> list[str]:
    """What `--mute` can name."""
    return ["telemeter", "displacement", *thermometers(ctx)]

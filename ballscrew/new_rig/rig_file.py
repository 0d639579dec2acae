"""The text of a rig.toml in which every guess is marked."""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

import tomlkit

from ballscrew.new_rig.geometry import Geometry
from ballscrew.new_rig.scan import ScanGuess
from ballscrew.new_rig.seen import Guess
from ballscrew.new_rig.temperatures import THERMOMETER
from estimator.rig import Signal
from estimator.rig_log import Csv, Log
from estimator.screw import Screw

HEAD = """A rig that `ballscrew init` made from {names}.
Each line with "guessed" is one to look at; those of places, sizes and material no recording tells."""
MARK = "guessed: {}; edit"
_STEEL = {"density": "steel, kg/m3", "heat_capacity": "steel, J/(kg K)", "conductivity": "steel, W/(m K)"}


def rig_text(
    name: str, names: str, tick_s: float, guesses: list[Guess], parts: Geometry, log: Mapping[str, tuple[Any, str]]
) -> str:
    """The file; `names` are those of the recordings, `log` has keys of [log] with what is guessed of each."""
    document = tomlkit.document()
    for line in HEAD.format(names=names).splitlines():
        document.add(tomlkit.comment(line))
    document.add("name", tomlkit.item(name))
    document.add("tick_s", tomlkit.item(tick_s))
    if parts.screw is not None:
        document.add("screw", _screw(parts.screw, parts))
    if parts.nut is not None:
        document.add("nut", _table([
            ("length_mm", parts.nut.length_mm, MARK.format("its length")),
            ("centre_mm", parts.nut.centre_mm, MARK.format("its centre at position 0: mid-screw in mid-stroke")),
            ("direction", parts.nut.direction, MARK.format("-1.0 where it moves to smaller x as the position grows")),
        ]))  # fmt: skip
    if parts.supports:
        why = {"free": "at the first thermometer", "anchor": "the fixed bearing, at the last thermometer"}
        rows = [(key, vars(one), MARK.format(why[key])) for key, one in parts.supports.items()]
        document.add("supports", _table(rows))
    if log:
        document.add("log", _table([(key, value, why and MARK.format(why)) for key, (value, why) in log.items()]))
    document.add("channels", _table(_channels(guesses, parts)))
    document.add("inputs", _table([*_inputs(guesses), *_missing(guesses, parts)]))
    return tomlkit.dumps(document)


def lines_of(text: str, keys: Collection[str]) -> str:
    """The lines of the file that guess the values of these keys, as "12 - 15"."""
    at = [k for k, line in enumerate(text.splitlines(), start=1) if line.partition(" =")[0].strip('"') in keys]
    at = [k for k in at if "guessed:" in text.splitlines()[k - 1]]
    return "" if not at else f"{at[0]}" if len(at) == 1 else f"{at[0]} - {at[-1]}"


def log_of_csv(time_column: str, csv: Csv, guessed: str) -> dict[str, tuple[Any, str]]:
    """[log] of a rig whose recordings are CSVs."""
    told = {key: value for key, value in vars(csv).items() if value != getattr(Csv(), key)}
    column = {"time_column": (time_column, "")} if time_column != Log.time_column else {}
    return column | ({"csv": (told, guessed)} if told else {})


def log_of_bus(dbc: str, bus: str, scan: ScanGuess) -> dict[str, tuple[Any, str]]:
    """[log] of a rig on a CAN bus: what of a scan holds is checked, and only what closes it is a guess."""
    keys = ("closes", "scan", "scan_state", "scan_crc", "scan_number", "checksums", "counters")
    told = {key: value for key in keys if (value := getattr(scan, key))}
    whys = {"closes": scan.why, "scan_state": "the text of most of them"}
    rows = {"dbc": (dbc, "")} | ({"bus": (bus, "the same messages come on another one too")} if bus else {})
    return rows | {key: (list(v) if isinstance(v, tuple) else v, whys.get(key, "")) for key, v in told.items()}


def _screw(screw: Screw, parts: Geometry) -> tomlkit.items.Table:
    lead = "" if parts.lead_found else MARK.format("its lead")
    return _table([
        ("from_mm", screw.from_mm, MARK.format("one end, beyond the first thermometer")),
        ("to_mm", screw.to_mm, MARK.format("the other end")),
        ("outer_mm", screw.outer_mm, MARK.format("its diameter")),
        ("bore_mm", screw.bore_mm, MARK.format("solid; the diameter of its bore")),
        *([("lead_mm", screw.lead_mm, lead or "from speed and position")] if parts.supports else []),
        *((key, getattr(screw, key), MARK.format(what)) for key, what in _STEEL.items()),
        ("expansion", screw.expansion, MARK.format("steel, 1/K")),
        ("span_from_mm", screw.span_from_mm, MARK.format("begin of the length whose growth is the elongation")),
        ("span_to_mm", screw.span_to_mm, MARK.format("its end")),
    ])  # fmt: skip


def _channels(guesses: list[Guess], parts: Geometry) -> Iterator[tuple[str, Any, str]]:
    for guess in guesses:
        if guess.role == THERMOMETER:
            place = (
                {"at_mm": parts.at_mm[guess.name]} if guess.name in parts.at_mm else {"node": parts.nodes[guess.name]}
            )
            said = "" if parts.told else "its place" if parts.at_mm else "a body of its own"
            yield guess.name, place | _rule(guess), said and MARK.format(said)
        elif guess.role == "displacement":
            yield guess.name, _rule(guess), _marked(guess)


def _inputs(guesses: list[Guess]) -> Iterator[tuple[str, Any, str]]:
    for guess in guesses:
        if guess.role not in (THERMOMETER, "displacement"):
            yield guess.name, _rule(guess), _marked(guess)


def _missing(guesses: list[Guess], parts: Geometry) -> Iterator[tuple[str, Any, str]]:
    """Surroundings that nobody measured: an input that never comes."""
    for name in ("ambient", "base") if parts.supports else ("ambient",):
        if name not in {guess.name for guess in guesses}:
            yield name, {"column": name}, "not in the recording: as warm as the rig was at the start"


def _marked(guess: Guess) -> str:
    also = f"; or {', '.join(one.source for one in guess.also[:3])}" if guess.also else ""
    return MARK.format(guess.why + also)


def _rule(guess: Guess) -> dict[str, Any]:
    """What of an entry is not as it would be without a word; a column of the same name is none."""
    default = Signal()
    told = {key: value for key, value in vars(guess.rule).items() if value != getattr(default, key)}
    if told.get("column") == guess.name:
        del told["column"]
    if isinstance(told.get("signal"), tuple):
        told["signal"] = list(told["signal"])
    return told


def _table(rows: Any) -> tomlkit.items.Table:
    """A table of rows (key, value, comment); a mapping becomes an inline table."""
    table = tomlkit.table()
    for key, value, said in rows:
        item = tomlkit.item(value)
        if isinstance(value, Mapping):
            item = tomlkit.inline_table()
            item.update(value)
        table.add(key, item)
        if said:
            item.comment(" ".join(said.split()))
    return table

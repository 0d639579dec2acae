"""What units and names say of a signal, in English and German as buses and loggers have them."""

import re
import unicodedata
from typing import NamedTuple

from drivers.units import unit_of

LEAD_MM = 12.0  # of a thread, where no recording tells it


class Unit(NamedTuple):
    """What a unit measures, and how it becomes the unit of rig.toml: scale * value + offset."""

    kind: str
    unit: str
    scale: float = 1.0
    offset: float = 0.0


_DEGREE = 0.017453292519943295
UNITS = {
    "degC": Unit("temperature", "degC"),
    "K": Unit("temperature", "K"),
    "degF": Unit("temperature", "degC", 0.5555555556, -17.7777777778),
    "rpm": Unit("speed", "rpm"),
    "rad/s": Unit("speed", "rad/s"),
    "1/s": Unit("speed", "rpm", 60.0),
    "deg/s": Unit("speed", "rad/s", _DEGREE),
    "mm/s": Unit("feed", "rpm", 60.0),
    "mm/min": Unit("feed", "rpm", 1.0),
    "m/min": Unit("feed", "rpm", 1000.0),
    "m/s": Unit("feed", "rpm", 60000.0),
    "mm": Unit("length", "mm"),
    "um": Unit("length", "mm", 1e-3),
    "nm": Unit("length", "mm", 1e-6),
    "m": Unit("length", "mm", 1000.0),
    "inch": Unit("length", "mm", 25.4),
    "A": Unit("current", "A"),
    "mA": Unit("current", "A", 1e-3),
    "W": Unit("power", "W"),
    "kW": Unit("power", "W", 1000.0),
    "mW": Unit("power", "W", 1e-3),
    "%": Unit("power", "%"),
}

_BRACKETS = re.compile(r"[\[(<{].*?[\])>}]")  # around a unit

# whole words of a name, or from five letters on parts of them
ROLES = {
    "ambient": "ambient air luft umgebung umgeb hall halle raum room outside aussen umgebungsluft",
    "base": "base bed bett frame gestell maschinenbett basis fundament foundation",
    "anchor_bracket": "festlager anchor fixedbearing bearingfix bracketanchor festlagerbock",
    "free_bracket": "loslager freebearing loosebearing bearingfree bearingloose bracketfree loslagerbock",
    "nut": "nut mutter kgm ballnut spindelmutter",
    "probe": "probe taster messtaster",
    "bar": "bar invar stange holder halter messstange",
    "board": "board pcb platine elektronik electronics coldjunction vergleichsstelle cj",
}
_ENDS = {"ambient": ("luft", "raum"), "base": ("bett",)}  # of longer words
TEMPERATURE = "t temp temperature temperatur tc pt thermo ntc rtd thermocouple thermoelement fuehler pt100 pt1000"
SPEED = "speed feed vorschub drehzahl rpm velocity geschwindigkeit omega n nist spindlespeed revs"
POSITION = "position pos lage place weg x axis achse achsposition stroke hub table tisch schlitten travel encoder"
LENGTH = (
    "displacement displ dsp growth elongation dehnung laengung verlagerung ausdehnung laengenaenderung expansion probe "
    "taster gauge messtaster verschiebung"
)
CURRENT = "current strom amps motorstrom"
POWER = "power leistung heat"
HEATER = "heater heizer heizung heizleistung heizpatrone"
WANTED = "set soll setpoint target cmd command demand ref reference sollwert"  # what was asked for, not what is
TIMES = "time stamp timestamp zeit zeitstempel elapsed"
AT_REST = "direct rest ruhe still static standstill stillstand park"
COUNTED = "crc checksum chk count counter cnt ctr seq sequence alive zaehler number scanno id status state mode flag"


def tokens(name: str) -> list[str]:
    """The words in a name, without accents, units in brackets and numbers: EnvAmbient, env_ambient [°C] ..."""
    plain = _BRACKETS.sub("", name)
    for letter, written in {"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"}.items():
        plain = plain.replace(letter, written)
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
    return [word.casefold() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", plain)]


def plain_name(name: str) -> str:
    """A name for rig.toml: words and numbers, without the unit."""
    bare = _BRACKETS.sub("", name).strip()
    bare = bare.removesuffix(unit_in_tail(bare))
    return "_".join([*tokens(bare), *map(str, number_in(bare))]) or name


def says(name: str, words: str) -> bool:
    """Whether one of these words is in a name: as a word, or from five letters on as a part of one."""
    found, known = tokens(name), words.split()
    joined = "".join(found)
    return bool({*found} & {*known}) or any(len(word) > 4 and word in joined for word in known)


def role_of(name: str) -> str:
    """Which temperature a name speaks of; "" for none that a model knows."""
    for role, words in ROLES.items():
        ends = any(word.startswith(end) or word.endswith(end) for word in tokens(name) for end in _ENDS.get(role, ()))
        if ends or says(name, words):
            return role
    return ""


def family(name: str) -> str:
    """A name without its numbers: those of one family differ in them only."""
    return re.sub(r"\d+", "#", name)


def number_in(name: str) -> tuple[int, ...]:
    """The numbers in a name, by which a family is in order."""
    return tuple(int(digits) for digits in re.findall(r"\d+", name))


def measure(unit: str) -> Unit | None:
    """What a unit as a DBC or CSV writes it measures; None for what no rig has."""
    return UNITS.get(unit_of(unit) or "")


def unit_in_tail(name: str) -> str:
    """The unit behind the last underscore or blank of a column, such as heater_W or "air C"; "" where it is none."""
    head, _, tail = re.sub(r"\s", "_", name.strip()).rpartition("_")
    return tail.strip("[]()") if head and measure(tail) else ""

"""Units as people, loggers and buses write them."""

_SAME = {  # what is meant, and how it is written
    "degC": "c °c ºc degc celsius ℃ degree_c deg_c °æ",
    "K": "k kelvin",
    "degF": "f °f ºf degf fahrenheit",
    "mK": "mk",
    "mV": "mv",
    "V": "v",
    "W": "w watt",
    "kW": "kw",
    "mW": "mw",
    "mm": "mm",
    "um": "um µm μm micron",
    "m": "m",
    "inch": 'in inch "',
    "rpm": "rpm 1/min min-1 min^-1 u/min r/min rev/min",
    "rad/s": "rad/s",
    "1/s": "1/s s-1 s^-1 rps u/s rev/s hz",
    "deg/s": "deg/s °/s",
    "mm/s": "mm/s",
    "mm/min": "mm/min",
    "m/min": "m/min",
    "m/s": "m/s",
    "A": "a",
    "mA": "ma",
    "%": "% percent",
    "s": "s sec secs second seconds sek sekunden",
    "ms": "ms msec millisecond milliseconds",
    "us": "us µs μs usec microsecond microseconds",
    "ns": "ns nanosecond nanoseconds",
    "min": "min mins minute minutes minuten",
    "h": "h hr hour hours stunden std",
    "d": "d day days tage",
}
_MISREAD = str.maketrans({"Â": None, "ø": "°", "¡": "°"})  # degrees of UTF-8, MS-DOS and old Macs as Windows has them
UNITS = {word: unit for unit, words in _SAME.items() for word in words.split()}
_KINDS = (
    "degC K degF mK mV V", "W kW mW %", "mm um nm m inch", "A mA", "rpm rad/s 1/s deg/s mm/s mm/min m/min m/s",
)  # fmt: skip
MEASURED = {unit for kind in _KINDS for unit in kind.split()}


def unit_of(text: str) -> str | None:
    """A unit as it is meant; None for what is none."""
    plain = text.translate(_MISREAD).strip().strip("[]()")
    return "nm" if plain == "nm" else UNITS.get(plain.replace(" ", "_").casefold())  # Nm is a torque


def contradicts(said: str, expected: str) -> bool:
    """Whether both are units of one kind of quantity, and not the same."""
    meant = UNITS.get(expected.casefold(), expected)
    return said != meant and any(said in kind.split() and meant in kind.split() for kind in _KINDS)

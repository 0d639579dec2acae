"""A foreign bus: the project's frames under other ids, messages and German names; and CSVs as a lab has them."""

import re
from pathlib import Path

from tests.conftest import ROOT

NAMES = {
    "EnvAmbient": "Umgebungsluft", "EnvBase": "Maschinenbett", "EnvBracketAnchor": "Festlager",
    "EnvBracketFree": "Loslager", "EnvNut": "Mutter", "EnvProbe": "Messtaster", "EnvBar": "Messstange",
    "TBoard": "Platine", "DrvSpeed": "Drehzahl", "DrvPosition": "Lage", "DrvCurrent": "Strom",
    "DspHold": "Hub", "DspDirect": "Ruhe", "DisplacementHold": "Laengung1", "DisplacementDirect": "Laengung2",
    "TelemeterStatus": "SpindelEnde", "TelScan": "Abtast", "Telemeter": "Spindel", "Drive": "Achse",
    "Environment": "Klima",
}  # fmt: skip
SHIFT = 0x100
IDS = (528, 529, 530, 531, 532, 544, 545, 560, 576, 577)


def dbc(path: Path, units: bool = True) -> Path:
    """The DBC of the same bus, as somebody else wrote it; without its units where asked."""
    text = (ROOT / "drivers" / "rig.dbc").read_text().partition("BO_ 1552")[0]
    values = [line for line in (ROOT / "drivers" / "rig.dbc").read_text().splitlines() if re.match(r"VAL_ 5", line)]
    text = "\n".join([text, *values, ""])
    for old, new in NAMES.items():
        text = re.sub(rf"\b{old}", new, text)
    text = re.sub(r"\bT(\d\d)\b", lambda found: f"Temp_{int(found[1])}", text)
    text = re.sub(r"\b(BO_|VAL_) (\d+)", lambda found: f"{found[1]} {int(found[2]) + SHIFT}", text)
    path.write_text(text if units else re.sub(r'"(degC|mm|rpm|um|A)"', '""', text))
    return path


def log(path: Path, source: Path) -> Path:
    """Its frames, made of a candump log of the project's rig."""
    lines = []
    for line in source.read_text().splitlines():
        stamp, bus, frame = line.split()
        name, data = frame.split("#")
        if int(name, 16) in IDS:
            lines.append(f"{stamp} {bus} {int(name, 16) + SHIFT:03X}#{data}\n")
    path.write_text("".join(lines))
    return path

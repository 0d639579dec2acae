"""Values in large letters and in colour, as a picture: the viewer's text has one colour and no such size."""

import io
from collections.abc import Sequence
from functools import cache

import matplotlib
import rerun as rr
from PIL import Image, ImageDraw, ImageFont

from viz.drawing import paths
from viz.drawing.entity import Entity
from viz.lanes.standing import Glance, Tone

WIDTH, HEIGHT = 1600, 110  # pixels: as wide as the window, and a seventh of a low one high
SHARES = (3.0, 3.0, 4.0)  # of the width; the last one says why
FONT, SMALL, LARGE, MARGIN = "/fonts/ttf/DejaVuSans.ttf", 17, 48, 18
COLOURS: dict[Tone, paths.Colour] = {
    "value": paths.REFERENCE, "valid": paths.OPEN_LOOP, "invalid": (255, 92, 80), "stale": (120, 120, 124),
}  # fmt: skip
COLOURS_KEPT = 16  # in the picture: letters have soft edges


def send(at: Entity, glances: Sequence[Glance], since_s: float) -> None:
    """Log the banner from a time on."""
    png = picture(glances)
    at.log(rr.EncodedImage(contents=png, media_type="image/png", magnification_filter="Linear"), since_s)


def picture(glances: Sequence[Glance]) -> bytes:
    """The values beside each other, as a PNG of few colours."""
    image = Image.new("RGB", (WIDTH, HEIGHT), paths.BACKGROUND)
    draw, shares, left = ImageDraw.Draw(image), SHARES[-len(glances) :], float(MARGIN)
    for glance, share in zip(glances, shares, strict=True):
        width = (WIDTH - MARGIN) * share / sum(shares)
        faint = paths.TEXT if glance.tone != "stale" else COLOURS["stale"]
        rows = (glance.caption, SMALL, faint, 3), (glance.value, LARGE, COLOURS[glance.tone], 23)
        for text, size, colour, top in (*rows, (glance.below, SMALL, faint, 84)):
            draw.text((left, top), _fitted(text, size, width), fill=colour, font=_font(size))
        left += width
    file = io.BytesIO()
    image.quantize(COLOURS_KEPT, dither=Image.Dither.NONE).save(file, "png")
    return file.getvalue()


@cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(matplotlib.get_data_path() + FONT, size)


def _fitted(text: str, size: int, width: float) -> str:
    """As much of a text as there is room for; the events have all of it."""
    room = width - MARGIN
    if _font(size).getlength(text) <= room:
        return text
    while _font(size).getlength(f"{text} ...") > room:
        text = text[:-1]
    return f"{text} ..."

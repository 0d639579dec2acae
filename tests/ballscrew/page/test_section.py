"""What a page is made of: whatever names hold, it stays text."""

from dataclasses import replace
from html.parser import HTMLParser

import pytest

from ballscrew.page.equations import equations
from ballscrew.page.page import page
from ballscrew.page.picture import COLOURS, STAND_INS, curve, legend, sheet
from ballscrew.page.section import Formula, Grid, Picture, Points, Section, Words, of_report
from ballscrew.report import sections as report
from estimator.effect import Effect, Param
from estimator.model import model_of

EVIL = "</h2><script>alert('&')</script> $2^x$"
VOID = {"meta", "br", "img"}


class Seen(HTMLParser):
    """Tags of a page, each with its attributes, and those that are open."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def values(self, key: str) -> list[str]:
        return [attributes[key] for _, attributes in self.tags if attributes.get(key)]


def sound(text: str) -> Seen:
    """The page, after it has been found to be whole and to need nothing besides itself."""
    seen = Seen(text)
    assert not seen.open
    assert not {tag for tag, _ in seen.tags} & {"script", "link", "iframe", "object"}
    assert not [key for _, attributes in seen.tags for key in attributes if key.startswith("on")]
    links = seen.values("href") + seen.values("xlink:href") + seen.values("src")
    assert all(link.startswith(("#", "data:image/png;base64,")) for link in links)
    assert "@import" not in text
    ids = seen.values("id")
    assert len(ids) == len(set(ids))
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)
    return seen


def drawn(name: str) -> Picture:
    import numpy as np

    with sheet(2.0) as one:
        axes = one.figure.subplots()
        curve(axes, np.arange(3.0), np.array([0.0, np.nan, 2.0]), "filter", name, np.ones(3))
        axes.set_title(name)
        legend(axes)
    return one.picture(name)


def test_names_that_hold_markup_are_text_everywhere():
    inside = Section(EVIL, [Words([EVIL]), Points([EVIL]), Formula(EVIL), Grid([[EVIL, EVIL], [EVIL, EVIL]])], level=3)
    one = Section(EVIL, [inside, drawn(EVIL), drawn("other"), of_report(report.Section(EVIL, [EVIL], [[EVIL]]))])
    text = page(EVIL, EVIL, [EVIL], [one])
    seen = sound(text)
    assert [tag for tag, _ in seen.tags].count("svg") == 2
    assert text.count("alert(") == text.count("&lt;script&gt;alert(") >= 14


def test_what_an_effect_of_one_s_own_says_is_text():
    class Evil(Effect):
        """<script>alert(1)</script> heats.

        q = P <b>x</b>
        """

        trace = "none"
        power = Param(0.0, "W</td>", lo=0.0, hi=1.0, null=0.0, source="<i>me</i>")

        def terms(self, p, u, rig):
            yield from ()

    text = page("t", "m", [], [equations(replace(model_of([Evil]), name="<em>"))])
    sound(text)
    assert "q = P &lt;b&gt;x&lt;/b&gt;" in text
    assert not [tag for tag in ("<i>", "<b>", "<em>", "<script") if tag in text]


def test_pictures_have_the_page_s_colours_light_and_dark():
    text = page("t", "m", [], [Section("s", [drawn("a")])])
    assert "var(--filter)" in text
    assert not [colour for colour in STAND_INS if colour in text]
    for name, (light, dark) in COLOURS.items():
        assert text.count(f"--{name}: {light};") == 2  # on the screen, and on paper whatever the screen has
        assert text.count(f"--{name}: {dark};") == 1


@pytest.mark.parametrize(
    ("plain", "printed"),
    [("band, um", "band, µm"), ("1/K um2 album", "1/K um2 album"), ("3 +- 1 degC", "3 ± 1 °C"), ("2 x off", "2 × off")],
)
def test_letters_that_a_terminal_does_without(plain, printed):
    assert f"<p>{printed}</p>" in Words([plain]).html()

"""One HTML file that needs nothing besides itself: a title, what is to be known first, and sections."""

from collections.abc import Sequence
from datetime import datetime
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

from ballscrew.page.picture import style
from ballscrew.page.section import Section, Words
from estimator.errors import InputError


def made_by(of: str, command: str) -> str:
    """Of what, by which command and when."""
    return f"{of}; made by ballscrew {command} on {datetime.now().isoformat(' ', 'minutes')}"


def page(title: str, made: str, lead: Sequence[str], sections: Sequence[Section]) -> str:
    """The whole page; `made`: of what and when, `lead`: what is to be known first."""
    template = Template((files("ballscrew.page") / "page.html").read_text(encoding="utf-8"))
    return template.substitute(
        version=version("ballscrew"),
        title=escape(title),
        made=escape(made),
        light=style(dark=False),
        dark=style(dark=True),
        lead=Words(lead).html(),
        sections="".join(section.html() for section in sections),
    )


def write(text: str, path: Path) -> None:
    """Write the page; one that cannot be written is an InputError."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from error

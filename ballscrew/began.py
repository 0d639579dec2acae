"""What began within recordings: a table, sentences with the clock's time, and JSON."""

from collections.abc import Sequence
from datetime import datetime

from ballscrew.report.sections import Section, number
from estimator.events.event import Event


def clock(event: Event, since_s: float | None = None) -> str | None:
    """Local time at which it began, or of another second, to the second; None where the log's clock tells no date."""
    if event.began_s is None:
        return None
    at_s = event.since_s if since_s is None else since_s
    return datetime.fromtimestamp(event.began_s + at_s).isoformat(" ", "seconds")


def sentence(event: Event) -> str:
    """What a person should know of it."""
    return event.told((clock(event) or "")[11:16], (clock(event, event.until_s) or "")[11:16])


def events_section(events: Sequence[Event]) -> Section:
    """A row and a sentence for each."""
    head = ["recording", "since, s", "until", "sd", "place", "W", "sd"]
    return Section("what began within a run", [sentence(event) for event in events], [head, *map(_row, events)])


def _row(event: Event) -> list[str]:
    place = " ".join(filter(None, (event.channel, event.name)))
    place = place or f"{event.from_mm:.0f} - {event.to_mm:.0f} mm"
    heat = ["", ""] if event.heat_W is None else [f"{event.heat_W:+.2f}", number(event.sd_W or 0.0)]
    until = "" if event.until_s is None else f"{event.until_s:.0f}"
    return [event.run, f"{event.since_s:.0f}", until, f"{event.sd_s:.0f}", place, *heat]


def events_json(events: Sequence[Event]) -> list[dict[str, object]]:
    """The same for programs."""
    return [
        {key: value for key, value in vars(event).items() if key not in ("began_s", "what")}
        | {"clock": clock(event), "sentence": sentence(event)}
        for event in events
    ]

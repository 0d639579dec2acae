"""What is written for a person or a program that takes nothing holds up nobody."""

import os
from functools import partial
from threading import Event

from rich.console import Console

from ballscrew.monitor.beside import Beside
from ballscrew.monitor.display import SENTENCES, Display
from ballscrew.terminal import Terminal


def test_jobs_are_done_in_their_order_and_what_has_no_room_is_lost():
    free, began, done = Event(), Event(), []

    def first() -> None:
        began.set()
        free.wait()

    beside = Beside(3)
    assert beside(first)
    began.wait()
    assert [beside(partial(done.append, n)) for n in range(5)] == [True, True, True, False, False]
    assert beside.full
    assert not beside.idle
    free.set()
    assert beside.close()
    assert done == [0, 1, 2]


def test_it_ends_though_a_job_does_not():
    began = Event()
    beside = Beside(1)
    beside(lambda: (began.set(), Event().wait()))
    began.wait()
    beside(print)
    assert not beside.close()


def test_a_terminal_that_takes_nothing_gets_what_there_was_room_for_once_it_does():
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    filled = 0
    try:
        while True:
            filled += os.write(writer, b"." * 256)
    except BlockingIOError:
        os.set_blocking(writer, True)
    terminal = Terminal()
    with open(writer, "w") as file, open(reader, "rb", buffering=0) as late:
        terminal.err = Console(file=file)
        display = Display(terminal, None)
        for n in range(3 * SENTENCES):
            display.say(f"alarm {n}", "WARN")
        text = b""
        while text.count(b"\n") < SENTENCES:
            text += late.read(1 << 16)
        assert display.close()
    told = [line.split()[-1] for line in text.lstrip(b".").decode().splitlines()]
    assert told[:SENTENCES] == [str(n) for n in range(SENTENCES)]

"""What a shell completes: click asks for it as bash, zsh and fish do."""

import pytest
from click.shell_completion import ShellComplete

from ballscrew.cli import main, root
from tests.conftest import PAPER


@pytest.mark.parametrize(
    ("typed", "begun", "offered"),
    [
        ("", "rev", {"review"}),
        ("add", "chu", {"churning"}),
        ("effects", "radi", {"radiation"}),
        ("simulate", "CS-2", {"CS-20", "CS-2.5"}),
        ("simulate FS-20 --plant", "chu", {"churning"}),
        ("new-effect jet --follows", "dri", {"drive"}),
        ("live --channels", "T01,T03,T0", {f"T01,T03,T0{n}" for n in range(1, 10)}),
        (f"review {PAPER}/FS-20.blf --mute", "d", {"displacement"}),
        ("review --rig no_such_folder --mute", "t", {"telemeter"}),
    ],
)
def test_names_are_completed(typed, begun, offered, monkeypatch):
    monkeypatch.chdir(PAPER)
    found = ShellComplete(root, {}, "ballscrew", "_BALLSCREW_COMPLETE").get_completions(typed.split(), begun)
    assert {one.value for one in found} == offered


@pytest.mark.parametrize("typed", [["add", "my_eff"], ["review", "FS"], ["show", "mod"], ["review", "--model", "m"]])
def test_files_are_left_to_the_shell(typed):
    (one,) = ShellComplete(root, {}, "ballscrew", "_BALLSCREW_COMPLETE").get_completions(typed[:-1], typed[-1])
    assert (one.type, one.value) == ("file", typed[-1])


def test_bash_is_told_by_the_command(monkeypatch, capfd):
    told = {"_BALLSCREW_COMPLETE": "bash_complete", "COMP_WORDS": "ballscrew add churn", "COMP_CWORD": "2"}
    for name, text in told.items():
        monkeypatch.setenv(name, text)
    with pytest.raises(SystemExit):
        main()
    assert capfd.readouterr().out == "plain,churning\n"

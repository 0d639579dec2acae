"""A population of machines: each the same whatever the seed, within the ranges of its build, and able to run."""

import json
from dataclasses import asdict, fields, is_dataclass, replace

import numpy as np
import pytest

from drivers.virtual_rig import simulate
from drivers.virtual_rig.frames.recording import write
from drivers.virtual_rig.machine import heat
from drivers.virtual_rig.machine.planted import BASE, PLANTED
from drivers.virtual_rig.population.constants import PAPER, Machine
from drivers.virtual_rig.population.draw import LAWS, REACHED_UM, SLOWEST, machine, steady_growth_um


@pytest.fixture(scope="module")
def many() -> list[Machine]:
    return [machine(number) for number in range(1, 121)]


def ranges():
    """Every drawn number: part, name, range."""
    parts = [f.name for f in fields(PAPER) if is_dataclass(getattr(PAPER, f.name))]
    return [
        (part, f.name, f.metadata["range"])
        for part in parts for f in fields(getattr(PAPER, part)) if "range" in f.metadata
    ]  # fmt: skip


def values(part: str, name: str, machines: list[Machine]) -> np.ndarray:
    return np.array([getattr(getattr(one, part), name) for one in machines])


def test_the_paper_s_machine_is_what_it_was():
    """Numbers of a run from before there were other machines."""
    run = simulate("FS-20", seconds=240.0, machine=0)
    assert float(run.truth.elongation_um[-1]) == pytest.approx(49.68046004684384, rel=1e-12)
    assert float(run.truth.channels[-1, 11]) == pytest.approx(30.276030723999988, rel=1e-12)
    assert float(run.truth.nut_torque.sum()) == pytest.approx(145.894, rel=1e-12)
    assert float(run.measured.channels.sum()) == pytest.approx(92475.69, abs=1e-6)
    assert float(run.holds.reading.elongation_um.sum()) == pytest.approx(5874.541465512048, rel=1e-12)


@pytest.mark.parametrize(("part", "name", "span"), ranges())
def test_every_number_is_drawn_in_its_range_where_its_law_holds(many, part, name, span):
    follows = np.array([not span.law or span.law in one.laws for one in many])
    drawn, elsewhere = values(part, name, many)[follows], values(part, name, many)[~follows]
    assert span.low <= drawn.min() < drawn.max() <= span.high
    assert np.unique(drawn).size == drawn.size
    assert set(elsewhere) <= {getattr(getattr(PAPER, part), name)}


def test_each_law_holds_on_its_share_of_the_machines(many):
    for name, law in LAWS.items():
        share = np.mean([name in one.laws for one in many])
        assert share == pytest.approx(law.share, abs=0.15), name


def test_channels_have_gains_and_lags_of_their_own(many):
    gains = np.array([one.sensors.gains for one in many])
    lags = np.array([one.sensors.lags for one in many])
    coarse = np.array(["coarse_gains" in one.laws for one in many])
    assert gains[~coarse].std() == pytest.approx(0.003, rel=0.1)
    assert gains[coarse].std() == pytest.approx(0.007, rel=0.1)
    assert 3.0 <= lags.min() < 5.0 < 12.0 < lags.max() <= 15.0


def test_a_number_is_one_machine_whatever_the_seed():
    runs = [simulate("FS-20", machine=5, seed=seed, seconds=60.0) for seed in (1, 2)]
    assert runs[0].machine == runs[1].machine == machine(5)
    assert not np.array_equal(runs[0].measured.channels, runs[1].measured.channels)


def test_machines_are_numbered_from_0_on():
    assert machine(0) is PAPER
    with pytest.raises(ValueError, match="machine -1: machines are numbered from 0"):
        simulate("FS-20", machine=-1)


@pytest.mark.parametrize("number", [0, 3])
def test_constants_are_written_beside_the_recording(number, tmp_path):
    write(simulate("FS-20", machine=number, seconds=2.0), tmp_path / "a.log")
    told = json.loads((tmp_path / "a.machine.json").read_text())
    one = machine(number)
    assert told["machine"] == number
    for part, constants in told["constants"].items():
        assert json.loads(json.dumps(asdict(getattr(one, part)))) == constants
        assert told["units"][part].keys() == constants.keys()
    assert {name for name, law in told["laws"].items() if law["holds"]} == set(one.laws)
    assert {law["form"] for law in told["laws"].values()} >= {LAWS[name].this for name in one.laws}


def test_steps_are_stable_on_every_machine(many):
    """dt < C / sum g at every node, with the steps of a screw at rest."""
    for one in many:
        parts = heat.parts(one, dict.fromkeys(BASE, 1.0) | dict.fromkeys(PLANTED, 0.0))
        steel, nut, film = parts.screw, parts.nut, parts.surface
        contact = nut.contact * (1.0 + 50.0 * nut.contact_growth)  # W/K, at a difference never seen
        seats = max((bearing.contact * bearing.seat).max() for bearing in (parts.anchor, parts.free))
        around = (film.still + film.rotating + 6.0) * film.area.max() + contact / nut.length + seats
        rates = [
            (2.0 * steel.along_bore + steel.across) / steel.bore_capacity,
            (2.0 * steel.along_outer + steel.across + around) / steel.outer_capacity,
            (contact + nut.to_table) / nut.capacity,
            *((b.contact + b.to_base + b.to_air + b.to_bracket) / b.capacity for b in (parts.anchor, parts.free)),
        ]
        assert max(rates) / heat.RESTING_STEPS < 0.5


@pytest.mark.parametrize("number", [1, 3, 5])
def test_other_machines_heat_as_the_paper_s_does(number):
    run = simulate("FS-20", machine=number, cycles=1, stop_s=900.0)
    assert all(np.isfinite(column).all() for column in (run.truth.channels, run.measured.channels, run.truth.seat))
    grown, stop = run.truth.elongation_um, run.travel.drives[0].stop_s
    assert 120.0 < stop - run.travel.drives[0].start_s < 450.0
    assert grown.max() == pytest.approx(50.0, abs=1.5)
    assert grown[-1] < grown.max() - 5.0


@pytest.mark.parametrize(("name", "number"), [("CS-10", 3), ("ES-2.5", 7)])
def test_slower_and_shorter_strokes_reach_50_um_too(name, number):
    run = simulate(name, machine=number, cycles=1, stop_s=2.0)
    assert run.travel.drives[0].stop_s < 7200.0
    assert run.truth.elongation_um.max() == pytest.approx(50.0, abs=1.5)


def test_growth_at_last_is_the_simulation_s():
    run = simulate("FS-2.5", plant={"nut_friction": 0.4}, cycles=1, max_drive_s=6000.0, stop_s=1.0)
    weak = replace(PAPER, nut=replace(PAPER.nut, drag_torque=0.4 * PAPER.nut.drag_torque))
    assert run.travel.drives[0].stop_s > 6000.0
    assert steady_growth_um(weak, SLOWEST) == pytest.approx(run.truth.elongation_um.max(), rel=0.2)


def test_every_machine_can_follow_the_protocol():
    assert all(steady_growth_um(machine(number), SLOWEST) > REACHED_UM for number in range(41))

"""What was used of recordings, in a table and for programs."""

from ballscrew.report.use_report import channel_json, left_out
from estimator.faults.fault import Suspicion
from estimator.faults.use import ChannelUse, Use

NAN = float("nan")


def test_what_may_have_drifted_has_rows_of_its_own_and_is_not_broken(small):
    suspicions = (Suspicion(-0.034, 10.0, 60.0), Suspicion(0.12, 100.0, NAN))
    one = ChannelUse(small.names[1], 200, 200, {}, (), suspicions)
    at = f"{one.channel} at {small.channels[one.channel].at_mm:g} mm"
    _, *rows = left_out([Use("a.log", 0.0, False, (one,), (), {}, {}, (), ())], small)
    assert rows == [
        ["a.log", at, "may drift, -0.03 K", "10 s", "60 s", "0"],
        ["a.log", at, "may drift, +0.12 K", "100 s", "the end", "0"],
    ]
    told = channel_json(one)
    assert (told["suspect"], told["spells"]) == (None, [])
    assert told["may_drift"][0] == {"most_K": -0.034, "from_s": 10.0, "to_s": 60.0}

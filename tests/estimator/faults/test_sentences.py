"""What is said of readings that were not used."""

from dataclasses import replace

from estimator.faults.sentences import sentences
from estimator.faults.use import Use
from estimator.screw import Bed


def test_a_bed_that_nobody_read_leaves_no_error_at_the_table_and_that_is_said(rig):
    use = Use("a.log", 0.0, False, (), (), {}, {}, ("base", "ambient"), ())
    usual = "was never read: the screw's temperature at the start stands for it"
    assert sentences([use], rig) == [f"a.log: input base {usual}", f"a.log: input ambient {usual}"]
    assert sentences([use], replace(rig, bed=Bed("base"))) == [
        f"a.log: input base {usual}",
        "a.log: the error at the table is not known, for nothing has been read of base, the temperature of the bed: "
        "correct its signal at inputs.base in rig.toml, or leave out [bed]",
        f"a.log: input ambient {usual}",
    ]

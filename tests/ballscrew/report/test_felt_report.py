"""What is said of the error at the table, before and after."""

from ballscrew.report.felt_report import AtTheTable, felt_sentence
from estimator.accuracy.accuracy import Accuracy
from estimator.missing_effect.felt import Felt


def left(seen_um: float, silent_um: float) -> Felt:
    return Felt(*(Accuracy((-um, 0.1), 0.1, 0.1) for um in (seen_um, silent_um)))


def test_what_is_worse_at_the_table_is_said_to_be():
    better, worse, alike = (
        felt_sentence([AtTheTable("held out", ["a", "b"], [left(*before), left(*after)])])
        for before, after in (((0.9, 1.2), (0.2, 0.3)), ((0.9, 1.2), (0.2, 1.9)), ((0.16, 0.1), (0.17, 0.11)))
    )
    assert "1.20 -> 0.30 um if they fall silent at the stop (held out)." in better
    assert "That is worse" not in better
    assert "That is worse" not in alike
    assert "1.20 -> 1.90 um" in worse
    assert worse.endswith("That is worse, whatever the model alone does: do not use it without more runs.")

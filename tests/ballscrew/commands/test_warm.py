"""ballscrew warm compiles all that is compiled."""

import json

from estimator.batch import batch
from tests.conftest import ballscrew


def test_after_it_nothing_is_left_to_compile():
    assert ballscrew("warm")[0] == 0
    assert not batch.is_cold()
    status, out, _ = ballscrew("warm", "--json")
    assert (status, json.loads(out)) == (0, {"compiled": False})

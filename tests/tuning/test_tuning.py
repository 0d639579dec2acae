"""Did the filter get worse on recordings? Better never fails. docs/tuning.md says what the figures mean."""

import pytest

from .compare import table, worse
from .kept import Kept, kept_path
from .measure import PAPER, Folder, fingerprint


def test_no_worse_than_kept(judged: str, folder: Folder, kept: Kept) -> None:
    figures = {key: value for key, value in kept.figures.items() if key[0] == judged}
    found = worse(figures, folder.figures([judged]), kept.tolerance)
    if found:
        changed = "the same, so the code changed" if kept.model == fingerprint(folder.model) else "changed"
        own = "" if folder.path.resolve() == PAPER else f" RIG={folder.path}"
        said = f'model: {changed}; if it is meant: make tuning REASON="why"{own}'
        pytest.fail(f"worse than in {kept_path(folder.path)}\n{table(found)}\n{said}", pytrace=False)

"""python-can and cantools without asammdf and pandas: they load these for MF4 alone, which takes longer than all else
that a command loads. What needs MF4 loads asammdf first, or `can.io.mf4` again.
"""

import sys
from importlib import import_module
from typing import Any

_for_mf4 = "asammdf" in sys.modules
sys.modules.setdefault("asammdf", None)  # type: ignore[arg-type]
try:
    import can as can
finally:
    if not _for_mf4:
        del sys.modules["asammdf"]


def __getattr__(name: str) -> Any:
    """cantools, late: it takes longer than reading a short log."""
    if name != "cantools":
        raise AttributeError(name)
    return import_module(name)

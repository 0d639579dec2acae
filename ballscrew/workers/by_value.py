"""Jobs and what comes of them as bytes, for another process: functions and effects of one's own travel by value."""

import io
import sys
from typing import Any
from uuid import uuid4
from weakref import WeakKeyDictionary, WeakValueDictionary

import cloudpickle

from estimator.effect import Effect

MOST_LOST = 3  # workers, at one job
KEPT = 64  # items that a worker keeps; the one asked of longest ago goes
LEFT_OUT = {"__dict__", "__weakref__", "params", "name"}  # of a class: each has its own, and an effect names itself

_name_of: WeakKeyDictionary[type, str] = WeakKeyDictionary()
_named: WeakValueDictionary[str, type] = WeakValueDictionary()

loads = cloudpickle.loads


def done(job: bytes, item: Any) -> bytes:
    """What a job makes of an item, and the error where it made none."""
    try:
        return dumps((loads(job)(item), None))
    except Exception as error:
        return dumps((None, error))


def answered(text: bytes) -> Any:
    """What a job made, here; its error is raised."""
    found, error = loads(text)
    if error is not None:
        raise error
    return found


def dumps(value: object) -> bytes:
    """A value as bytes; a class of effects that no module can be asked for comes back as the same class."""
    out = io.BytesIO()
    _Pickler(out).dump(value)
    return out.getvalue()


class _Pickler(cloudpickle.Pickler):  # type: ignore[misc]
    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, type) and issubclass(value, Effect) and not _is_imported(value):
            namespace = {key: part for key, part in vars(value).items() if key not in LEFT_OUT}
            return _effect, (_told_apart(value), value.__name__, value.__bases__, namespace)
        return super().reducer_override(value)


def _is_imported(value: type) -> bool:
    return getattr(sys.modules.get(value.__module__), value.__name__, None) is value


def _told_apart(effect: type) -> str:
    """A name that no other class has in any process."""
    name = _name_of.setdefault(effect, uuid4().hex)
    _named[name] = effect
    return name


def _effect(name: str, *parts: Any) -> type:
    """The class of that name, made where it is not known yet."""
    if name not in _named:
        effect = type(*parts)
        _name_of[effect] = name
        _named[name] = effect
        return effect
    return _named[name]

"""Functions that numba compiles when they are first called: to import it takes a fifth of a second, and most of what a
command does before that, its help, an error in a file, needs no filter.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


class Compiled:
    """A function that is compiled with the options `how`; the parts that it calls, of its module, before it."""

    def __init__(self, function: Callable[..., Any], how: dict[str, Any]) -> None:
        self.function, self.how = function, how

    def __call__(self, *args: Any) -> Any:
        return self.dispatcher(*args)

    @cached_property
    def dispatcher(self) -> Any:
        """numba's own function; its code is kept where there is a place for it (not in a read-only install)."""
        from numba import njit

        names = self.function.__globals__
        for name, value in list(names.items()):
            if isinstance(value, Compiled) and "forceinline" in value.how:
                names[name] = njit(**value.how)(value.function)  # numba knows no other kind of function
        try:
            return njit(**self.how)(self.function)
        except RuntimeError:
            return njit(**self.how | {"cache": False})(self.function)


def compiled(function: Function, **how: Any) -> Function:
    """The function, to be compiled."""
    return cast(Function, Compiled(function, how))

from typing import Any, Protocol, Sequence, Union

import numpy as np
import numpy.typing as npt

class _Array(Protocol):
    def __array__(self) -> Any: ...

# What options accept.
OptionValue = Union[bool, int, float, str]
# What the functions convert to an array. With numpy's own type, mypy refuses a matrix with rows of integers and of reals.
ArrayLike = Union[_Array, float, Sequence["ArrayLike"]]

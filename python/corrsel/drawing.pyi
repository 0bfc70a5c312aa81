from typing import Optional

import numpy as np
import numpy.typing as npt

from ._types import ArrayLike
from .selectors import Matches, Selection

def draw(
    image_left: Optional[ArrayLike],
    image_right: Optional[ArrayLike],
    matches: Matches,
    selection: Selection,
    *,
    width: int = ...,
    max_lines: int = ...,
    title: str = ...
) -> npt.NDArray[np.uint8]: ...

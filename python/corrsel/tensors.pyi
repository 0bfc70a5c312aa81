from typing import Any, Dict, Mapping, Optional, Tuple

from ._types import ArrayLike, OptionValue
from .selectors import Matches

def matches_of(
    output: Mapping[str, Any],
    image0: Any = ...,
    image1: Any = ...,
    *,
    left_size: Optional[ArrayLike] = ...,
    right_size: Optional[ArrayLike] = ...
) -> Matches: ...
def filter_matches(
    output: Mapping[str, Any],
    image0: Any = ...,
    image1: Any = ...,
    selector: str = ...,
    *,
    left_size: Optional[ArrayLike] = ...,
    right_size: Optional[ArrayLike] = ...,
    **options: OptionValue
) -> Dict[str, Any]: ...
def match_adalam(
    desc1: Any,
    desc2: Any,
    lafs1: Any,
    lafs2: Any,
    config: Optional[Mapping[str, Any]] = ...,
    hw1: Optional[Tuple[int, int]] = ...,
    hw2: Optional[Tuple[int, int]] = ...,
    dm: Any = ...,
) -> Tuple[Any, Any]: ...

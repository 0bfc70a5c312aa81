import os
from typing import Any, Dict, Mapping, NamedTuple, Optional, Union

from ._types import OptionValue

class Verified(NamedTuple):
    pairs: int
    accepted: int
    matches: int
    kept: int

def verify(
    matches: Union[str, os.PathLike[str]],
    features: Union[str, os.PathLike[str]],
    output: Union[str, os.PathLike[str]],
    pairs: Optional[Union[str, os.PathLike[str]]] = ...,
    selector: str = ...,
    *,
    scores: str = ...,
    **options: OptionValue
) -> Verified: ...
def match(data: Mapping[str, Any], selector: str = ..., **options: OptionValue) -> Dict[str, Any]: ...
def register(selector: str = ..., **options: OptionValue) -> Dict[str, Any]: ...

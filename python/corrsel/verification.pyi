import os
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._types import OptionValue

class FaultyPair(NamedTuple):
    first: str
    second: str
    message: str

class VerifyReport:
    CONFIGS: Tuple[str, ...]
    STATUSES: Tuple[str, ...]
    SCENES: Tuple[str, ...]
    path: str
    images: Dict[int, str]
    pairs: npt.NDArray[np.uint32]
    putative: npt.NDArray[np.uint32]
    inliers: npt.NDArray[np.uint32]
    config: npt.NDArray[np.uint8]
    status: npt.NDArray[np.uint8]
    scene: npt.NDArray[np.uint8]
    confidence: npt.NDArray[np.float64]
    ambiguity: npt.NDArray[np.float64]
    faulty: List[FaultyPair]
    warnings: List[str]
    configuration: str
    verified: int
    skipped: int
    of_others: int
    seconds: float
    def __init__(self, path: str, **values: Any) -> None: ...
    @property
    def accepted(self) -> npt.NDArray[np.bool_]: ...
    @property
    def configs(self) -> Dict[str, int]: ...
    def names(self) -> List[Tuple[str, str]]: ...
    def __len__(self) -> int: ...

def verify(
    database: Union[str, os.PathLike[str]],
    output: Optional[Union[str, os.PathLike[str]]] = ...,
    selector: Optional[str] = ...,
    *,
    features: Optional[Union[str, os.PathLike[str]]] = ...,
    threads: int = ...,
    pairs: Optional[Iterable[Tuple[str, str]]] = ...,
    again: bool = ...,
    strict: bool = ...,
    dry_run: bool = ...,
    memory: float = ...,
    progress: Optional[Callable[[int, int, int, float], Any]] = ...,
    **options: OptionValue
) -> VerifyReport: ...

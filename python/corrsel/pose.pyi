from typing import Any, Mapping, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._types import ArrayLike
from .selectors import Selection

class Pose(NamedTuple):
    rotation: npt.NDArray[np.float64]
    translation: npt.NDArray[np.float64]

class PosePrior:
    rotation: Optional[npt.NDArray[np.float64]]
    vertical: Optional[Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]
    rig: Optional[Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]
    def __init__(
        self,
        *,
        rotation: Optional[ArrayLike] = ...,
        vertical: Optional[Tuple[ArrayLike, ArrayLike]] = ...,
        rig: Optional[Tuple[ArrayLike, ArrayLike]] = ...
    ) -> None: ...
    def __hash__(self) -> int: ...

class MotionGuess:
    rotation: npt.NDArray[np.float64]
    translation: Optional[npt.NDArray[np.float64]]
    rotation_sigma: float
    def __init__(
        self, rotation: ArrayLike, *, translation: Optional[ArrayLike] = ..., rotation_sigma: float = ...
    ) -> None: ...
    def __hash__(self) -> int: ...

class PoseResult:
    motion: str
    rotation: npt.NDArray[np.float64]
    translation: npt.NDArray[np.float64]
    basis: Optional[npt.NDArray[np.float64]]
    covariance: npt.NDArray[np.float64]
    uncertain: bool
    noise: float
    parallax: float
    second: Optional[Pose]
    def __init__(self, **values: Any) -> None: ...
    @classmethod
    def from_core(cls, values: Optional[Mapping[str, Any]]) -> Optional[PoseResult]: ...

class RelativePose(PoseResult):
    mask: npt.NDArray[np.bool_]
    status: str
    confidence: float
    message: str
    def __init__(self, selection: Selection) -> None: ...

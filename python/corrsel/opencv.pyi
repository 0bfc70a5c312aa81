from typing import Any, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._types import ArrayLike

_Answer = Tuple[Optional[npt.NDArray[np.float64]], npt.NDArray[np.uint8]]

def findHomography(
    srcPoints: ArrayLike,
    dstPoints: ArrayLike,
    method: Union[int, str] = ...,
    ransacReprojThreshold: float = ...,
    mask: Optional[npt.NDArray[np.uint8]] = ...,
    maxIters: int = ...,
    confidence: float = ...,
) -> _Answer: ...
def findFundamentalMat(
    points1: ArrayLike,
    points2: ArrayLike,
    method: Union[int, str] = ...,
    ransacReprojThreshold: float = ...,
    confidence: float = ...,
    maxIters: Union[int, npt.NDArray[np.uint8]] = ...,
    mask: Optional[npt.NDArray[np.uint8]] = ...,
) -> _Answer: ...
def findEssentialMat(points1: ArrayLike, points2: ArrayLike, *arguments: Any, **keywords: Any) -> _Answer: ...
def matchGMS(
    size1: ArrayLike,
    size2: ArrayLike,
    keypoints1: Sequence[Any],
    keypoints2: Sequence[Any],
    matches1to2: Sequence[Any],
    withRotation: bool = ...,
    withScale: bool = ...,
    thresholdFactor: float = ...,
) -> List[Any]: ...

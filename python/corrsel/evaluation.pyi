from typing import Any, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._types import ArrayLike
from .selectors import Matches

class Evaluation:
    n_putative: int
    n_ground_truth: int
    n_selected: int
    tolerance: Any
    n_correct: Any
    precision: Any
    recall_paper: Any
    recall_same_tau: Any
    f_paper: Any
    f_same_tau: Any
    def __init__(self, **values: Any) -> None: ...

class PoseErrors(NamedTuple):
    rotation: float
    translation: float
    pose: float

def ground_truth_errors(
    matches: Matches,
    *,
    homography: Optional[ArrayLike] = ...,
    fundamental: Optional[ArrayLike] = ...,
    labels: Optional[ArrayLike] = ...,
    disparity: Optional[ArrayLike] = ...
) -> npt.NDArray[np.float64]: ...
def evaluate(
    matches: Matches,
    mask: ArrayLike,
    *,
    homography: Optional[ArrayLike] = ...,
    fundamental: Optional[ArrayLike] = ...,
    labels: Optional[ArrayLike] = ...,
    disparity: Optional[ArrayLike] = ...,
    tolerance: Optional[ArrayLike] = ...,
    ground_truth_tolerance: Optional[float] = ...
) -> Evaluation: ...
def pose_errors(
    rotation: ArrayLike,
    translation: ArrayLike,
    true_rotation: ArrayLike,
    true_translation: ArrayLike,
) -> PoseErrors: ...
def error_auc(errors: ArrayLike, thresholds: Optional[ArrayLike] = ...) -> npt.NDArray[np.float64]: ...
def mean_interval(values: ArrayLike) -> Tuple[float, float, float]: ...
def mean_average_accuracy(errors: ArrayLike, thresholds: Optional[ArrayLike] = ...) -> float: ...
def epipolar_errors(
    matches: Matches,
    rotation: ArrayLike,
    translation: ArrayLike,
    left_camera: ArrayLike,
    right_camera: ArrayLike,
) -> npt.NDArray[np.float64]: ...
def corner_error(homography: ArrayLike, true_homography: ArrayLike, left_size: ArrayLike) -> float: ...

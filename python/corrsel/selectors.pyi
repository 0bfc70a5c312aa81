from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._options import Option
from ._types import ArrayLike, OptionValue
from .camera import Camera
from .pose import MotionGuess, PosePrior, PoseResult, RelativePose

class Matches:
    left: npt.NDArray[np.float32]
    right: npt.NDArray[np.float32]
    distance: Optional[npt.NDArray[np.float32]]
    second_distance: Optional[npt.NDArray[np.float32]]
    probability: Optional[npt.NDArray[np.float32]]
    left_frame: Optional[npt.NDArray[np.float32]]
    right_frame: Optional[npt.NDArray[np.float32]]
    left_index: Optional[npt.NDArray[np.uint32]]
    right_index: Optional[npt.NDArray[np.uint32]]
    left_size: Optional[Tuple[int, int]]
    right_size: Optional[Tuple[int, int]]
    left_camera: Optional[Camera]
    right_camera: Optional[Camera]
    prior: Optional[PosePrior]
    guess: Optional[MotionGuess]
    def __init__(
        self,
        left: ArrayLike,
        right: ArrayLike,
        *,
        distance: Optional[ArrayLike] = ...,
        second_distance: Optional[ArrayLike] = ...,
        probability: Optional[ArrayLike] = ...,
        left_frame: Optional[ArrayLike] = ...,
        right_frame: Optional[ArrayLike] = ...,
        left_index: Optional[ArrayLike] = ...,
        right_index: Optional[ArrayLike] = ...,
        left_size: Optional[ArrayLike] = ...,
        right_size: Optional[ArrayLike] = ...,
        left_camera: Optional[Camera] = ...,
        right_camera: Optional[Camera] = ...,
        prior: Optional[PosePrior] = ...,
        guess: Optional[MotionGuess] = ...
    ) -> None: ...
    def select(self, selector: str, **options: OptionValue) -> Selection: ...
    def with_cameras(self, left_camera: Optional[Camera], right_camera: Optional[Camera]) -> Matches: ...
    def __len__(self) -> int: ...
    def __getitem__(self, rows: Union[slice, ArrayLike]) -> Matches: ...

class Selection:
    mask: npt.NDArray[np.bool_]
    score: Optional[npt.NDArray[np.float32]]
    group: Optional[npt.NDArray[np.int32]]
    motion: Optional[Tuple[str, ...]]
    model: Optional[npt.NDArray[np.float64]]
    model_kind: str
    status: str
    scene: str
    confidence: float
    sigma: float
    probability: Optional[npt.NDArray[np.float32]]
    pose: Optional[PoseResult]
    guess: str
    message: str
    seconds: float
    iterations: int
    n_input: int
    n_ignored: int
    n_selected: int
    def __init__(self, **values: Any) -> None: ...

class Selector:
    def __init__(self, name: str, **options: OptionValue) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def options(self) -> List[Option]: ...
    def select(self, matches: Matches) -> Selection: ...

def select(
    left: ArrayLike,
    right: ArrayLike,
    selector: str,
    *,
    left_size: Optional[ArrayLike] = ...,
    right_size: Optional[ArrayLike] = ...,
    distance: Optional[ArrayLike] = ...,
    second_distance: Optional[ArrayLike] = ...,
    probability: Optional[ArrayLike] = ...,
    left_frame: Optional[ArrayLike] = ...,
    right_frame: Optional[ArrayLike] = ...,
    left_index: Optional[ArrayLike] = ...,
    right_index: Optional[ArrayLike] = ...,
    left_camera: Optional[Camera] = ...,
    right_camera: Optional[Camera] = ...,
    **options: OptionValue
) -> Selection: ...
def relative_pose(
    left: ArrayLike,
    right: ArrayLike,
    camera_left: Camera,
    camera_right: Camera,
    *,
    distance: Optional[ArrayLike] = ...,
    second_distance: Optional[ArrayLike] = ...,
    probability: Optional[ArrayLike] = ...,
    left_frame: Optional[ArrayLike] = ...,
    right_frame: Optional[ArrayLike] = ...,
    left_index: Optional[ArrayLike] = ...,
    right_index: Optional[ArrayLike] = ...,
    left_size: Optional[ArrayLike] = ...,
    right_size: Optional[ArrayLike] = ...,
    rotation: Optional[ArrayLike] = ...,
    vertical: Optional[Tuple[ArrayLike, ArrayLike]] = ...,
    rig: Optional[Tuple[ArrayLike, ArrayLike]] = ...,
    **options: OptionValue
) -> RelativePose: ...
def add_probability(matches: Matches, selection: Selection) -> None: ...
def label_motion(matches: Matches, selection: Selection) -> None: ...
def selector_names() -> List[str]: ...
def selector_groups() -> Dict[str, List[str]]: ...
def selector_presets(name: str) -> List[str]: ...

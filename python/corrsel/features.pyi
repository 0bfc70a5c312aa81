from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._options import Option
from ._types import ArrayLike, OptionValue
from .camera import Camera
from .pose import MotionGuess
from .selectors import Matches

class Features:
    points: npt.NDArray[np.float32]
    descriptors: npt.NDArray[Any]
    frame: Optional[npt.NDArray[np.float32]]
    size: Optional[npt.NDArray[np.float32]]
    angle: Optional[npt.NDArray[np.float32]]
    response: Optional[npt.NDArray[np.float32]]
    octave: Optional[npt.NDArray[np.int32]]
    image_size: Optional[Tuple[int, int]]
    detect_seconds: float
    describe_seconds: float
    def __init__(
        self,
        points: ArrayLike,
        descriptors: ArrayLike,
        *,
        frame: Optional[ArrayLike] = ...,
        size: Optional[ArrayLike] = ...,
        angle: Optional[ArrayLike] = ...,
        response: Optional[ArrayLike] = ...,
        octave: Optional[ArrayLike] = ...,
        image_size: Optional[ArrayLike] = ...,
        detect_seconds: float = ...,
        describe_seconds: float = ...
    ) -> None: ...
    def __len__(self) -> int: ...

class Extractor:
    def __init__(self, features: str = ..., **algorithms: Mapping[str, OptionValue]) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def options(self) -> Dict[str, List[Option]]: ...
    def extract(
        self,
        image: ArrayLike,
        *,
        mask: Optional[ArrayLike] = ...,
        area: Optional[ArrayLike] = ...,
        threads: int = ...
    ) -> Features: ...
    def match(
        self,
        image_left: ArrayLike,
        image_right: ArrayLike,
        *,
        left_mask: Optional[ArrayLike] = ...,
        right_mask: Optional[ArrayLike] = ...,
        left_area: Optional[ArrayLike] = ...,
        right_area: Optional[ArrayLike] = ...,
        left_camera: Optional[Camera] = ...,
        right_camera: Optional[Camera] = ...,
        guess: Optional[MotionGuess] = ...,
        threads: int = ...,
        **options: OptionValue
    ) -> Matches: ...

def extract(
    image: ArrayLike,
    features: str = ...,
    *,
    mask: Optional[ArrayLike] = ...,
    area: Optional[ArrayLike] = ...,
    threads: int = ...,
    **algorithms: Mapping[str, OptionValue]
) -> Features: ...
def match(
    image_left: ArrayLike,
    image_right: ArrayLike,
    features: str = ...,
    *,
    left_mask: Optional[ArrayLike] = ...,
    right_mask: Optional[ArrayLike] = ...,
    left_area: Optional[ArrayLike] = ...,
    right_area: Optional[ArrayLike] = ...,
    left_camera: Optional[Camera] = ...,
    right_camera: Optional[Camera] = ...,
    guess: Optional[MotionGuess] = ...,
    threads: int = ...,
    **options: Union[OptionValue, Mapping[str, OptionValue]]
) -> Matches: ...
def match_features(
    left: Features,
    right: Features,
    *,
    left_camera: Optional[Camera] = ...,
    right_camera: Optional[Camera] = ...,
    guess: Optional[MotionGuess] = ...,
    threads: int = ...,
    **options: OptionValue
) -> Matches: ...
def extractor_names() -> List[str]: ...
def detector_names() -> List[str]: ...
def descriptor_names() -> List[str]: ...
def missing_algorithms() -> Dict[str, str]: ...

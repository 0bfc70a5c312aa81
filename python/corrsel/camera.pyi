from typing import Any, Literal, Mapping, Optional, Tuple, overload

import numpy as np
import numpy.typing as npt

from ._types import ArrayLike

class Camera:
    model: str
    matrix: Optional[npt.NDArray[np.float64]]
    distortion: npt.NDArray[np.float64]
    size: Optional[Tuple[int, int]]
    def __init__(
        self,
        model: str,
        matrix: Optional[ArrayLike] = ...,
        distortion: ArrayLike = ...,
        size: Optional[ArrayLike] = ...,
    ) -> None: ...
    @classmethod
    def from_opencv(
        cls,
        matrix: ArrayLike,
        distortion: Optional[ArrayLike] = ...,
        size: Optional[ArrayLike] = ...,
        *,
        fisheye: bool = ...
    ) -> Camera: ...
    @classmethod
    def from_camera_info(cls, info: Any) -> Camera: ...
    @classmethod
    def from_colmap(cls, model: str, width: int, height: int, params: ArrayLike) -> Camera: ...
    @classmethod
    def from_kalibr(cls, camera: Mapping[str, Any]) -> Camera: ...
    def scaled(self, factor: float) -> Camera: ...
    @overload
    def unproject(self, points: ArrayLike, *, jacobians: Literal[False] = ...) -> npt.NDArray[np.float64]: ...
    @overload
    def unproject(
        self, points: ArrayLike, *, jacobians: Literal[True]
    ) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
    def project(self, points: ArrayLike) -> npt.NDArray[np.float64]: ...
    def __hash__(self) -> int: ...

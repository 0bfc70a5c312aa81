from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np
import numpy.typing as npt

class KeypointsAndMatches(NamedTuple):
    left: List[Any]
    right: List[Any]
    matches: List[Any]

def points(msg: Any) -> Tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]: ...
def keypoints(msg: Any) -> KeypointsAndMatches: ...
def selected_rows(msg: Any) -> npt.NDArray[np.intp]: ...
def groups(msg: Any) -> Optional[npt.NDArray[np.int32]]: ...

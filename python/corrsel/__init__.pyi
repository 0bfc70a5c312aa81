from ._options import Option as Option, options as options
from .camera import Camera as Camera
from .drawing import draw as draw
from .evaluation import (
    Evaluation as Evaluation,
    PoseErrors as PoseErrors,
    corner_error as corner_error,
    epipolar_errors as epipolar_errors,
    error_auc as error_auc,
    evaluate as evaluate,
    ground_truth_errors as ground_truth_errors,
    mean_average_accuracy as mean_average_accuracy,
    mean_interval as mean_interval,
    pose_errors as pose_errors,
)
from .features import (
    Extractor as Extractor,
    Features as Features,
    descriptor_names as descriptor_names,
    detector_names as detector_names,
    extract as extract,
    extractor_names as extractor_names,
    match as match,
    match_features as match_features,
    missing_algorithms as missing_algorithms,
)
from .pose import (
    MotionGuess as MotionGuess,
    Pose as Pose,
    PosePrior as PosePrior,
    PoseResult as PoseResult,
    RelativePose as RelativePose,
)
from .selectors import (
    Matches as Matches,
    Selection as Selection,
    Selector as Selector,
    add_probability as add_probability,
    label_motion as label_motion,
    relative_pose as relative_pose,
    select as select,
    selector_groups as selector_groups,
    selector_names as selector_names,
    selector_presets as selector_presets,
)
from .verification import FaultyPair as FaultyPair, VerifyReport as VerifyReport, verify as verify

__version__: str

"""Selection of the inliers among putative 2D feature matches, over numpy arrays.

    matches = corrsel.match(image_left, image_right, features="sift+sift")
    selection = matches.select("auto")
    good_left, good_right = matches.left[selection.mask], matches.right[selection.mask]

Matches of another matcher: corrsel.select(left, right, "auto", left_size=(640, 480), right_size=(640, 480)).

    select, Selector, Selection        decide which matches are inliers
    add_probability                    how probably each match is right, for any selection
    label_motion                       which groups of matches are objects that move by themselves
    selector_names, selector_groups, selector_presets   what there is to choose from
    options, Option                    options of selectors, features and matching, with ranges and meanings
    Matches                            putative matches with all their columns
    Camera                             a calibrated camera: pinhole, fisheye or panorama, to rays and back
    relative_pose, RelativePose        how a calibrated camera has moved between two images, with a covariance
    PosePrior                          what is known of the motion beforehand, for example from an inertial unit
    MotionGuess                        what is believed of it before matching, for example from a gyroscope
    PoseResult, Pose                   what Selection.pose of a calibrated selector holds
    draw                               a picture of what was kept and what was rejected
    match, match_features              putative matches of two images, or of their features
    extract, Extractor, Features       keypoints, affine frames and descriptors
    extractor_names, detector_names, descriptor_names, missing_algorithms
    verify, VerifyReport, FaultyPair   verification of all pairs of a database of COLMAP
    ground_truth_errors, evaluate, Evaluation   precision, recall and F against ground truth
    pose_errors, PoseErrors, epipolar_errors, corner_error   errors of an estimated pose or homography
    error_auc, mean_average_accuracy   of the errors of many pairs
    mean_interval                      mean of many values with its bootstrap interval

The modules corrsel.opencv, corrsel.tensors and corrsel.hloc have the signatures of other libraries (docs/doors.md).
The modules corrsel.matches and corrsel.messages serve programs that use the ROS messages of corrsel.msg; nothing else
needs ROS.
The modules in C++ are loaded on first use: `import corrsel.msg` works where they are not built.
"""

import importlib as _importlib
import importlib.util as _importlib_util

#: Public names by the module that defines them, and the module in C++ that this one needs.
_HOMES = {
    ("_options", "_core"): ("Option", "options"),
    ("camera", "_core"): ("Camera",),
    ("pose", "_core"): ("MotionGuess", "Pose", "PosePrior", "PoseResult", "RelativePose"),
    ("selectors", "_core"): (
        "Matches",
        "Selection",
        "Selector",
        "add_probability",
        "label_motion",
        "relative_pose",
        "select",
        "selector_groups",
        "selector_names",
        "selector_presets",
    ),
    ("evaluation", "_core"): (
        "Evaluation",
        "PoseErrors",
        "corner_error",
        "epipolar_errors",
        "error_auc",
        "evaluate",
        "ground_truth_errors",
        "mean_average_accuracy",
        "mean_interval",
        "pose_errors",
    ),
    ("features", "_features"): (
        "Extractor",
        "Features",
        "descriptor_names",
        "detector_names",
        "extract",
        "extractor_names",
        "match",
        "match_features",
        "missing_algorithms",
    ),
    ("drawing", "_features"): ("draw",),
    ("verification", "_database"): ("FaultyPair", "VerifyReport", "verify"),
    ("_core", "_core"): ("__version__",),
}

__all__ = [
    _name
    for (_, _built), _names in _HOMES.items()
    if _importlib_util.find_spec(__name__ + "." + _built)
    for _name in _names
    if not _name.startswith("_")
]


def __getattr__(name):
    for (home, built), names in _HOMES.items():
        if name in names:
            try:
                _importlib.import_module(__name__ + "." + built)
            except ImportError as error:
                raise ImportError(
                    "corrsel.%s needs the module corrsel.%s, which cannot be loaded (%s). %s"
                    % (name, built, error, _remedy(str(error)))
                ) from error
            value = getattr(_importlib.import_module(__name__ + "." + home), name)
            globals()[name] = value
            return value
    raise AttributeError("module %r has no attribute %r" % (__name__, name))


def _remedy(reason):
    """Return what to do where a module in C++ cannot be loaded."""
    import re  # pylint: disable=import-outside-toplevel  # only where something is missing

    library = re.match(r"lib(\S+)\.so\.([\d.]*\d): cannot open", reason)
    if library and library.group(1).startswith("opencv_"):
        return (
            "OpenCV's libraries are those of the system. Install Debian's package libopencv-%s%s; where the release has "
            "another version of OpenCV, build corrsel on it: 'pip install .' in the folder of its sources"
            % (library.group(1)[len("opencv_") :], library.group(2))
        )
    if library:
        return (
            "This library is one of the system. Install the package that has it, or build corrsel on this system: "
            "'pip install .' in the folder of its sources"
        )
    return (
        "It is built where pybind11 and Python's development files are found, for the Python that CMake reports; "
        "corrsel._features also needs -Dcorrsel_FEATURES=ON, and corrsel._database -Dcorrsel_DATABASE=ON"
    )


def __dir__():
    return sorted(set(globals()) | set(__all__))

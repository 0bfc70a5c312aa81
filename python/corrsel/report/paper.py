"""What the paper printed: Zhao, Yang, Xiao and Cao, "Comparative evaluation of 2D feature correspondence
selection algorithms", arXiv:1904.13383. Data only, each block with the table or figure it comes from (in
brackets the label in the paper's source).

Precision, recall and F are in percent, as printed. Selectors have this package's names.
"""
from collections import namedtuple

SOURCE = "arXiv:1904.13383"
SELECTORS = ("nnsr", "ransac", "st", "gtm", "usac", "vfc", "gms", "lpm")
FEATURES_DEFAULT = "hessian_affine+sift"  # section III-A
TAU_PX = 5.0  # of every table of single numbers

# Table II (tab:dataset): matching pairs.
DATASET_PAIRS = {"vgg": 40, "symbench": 46, "heinly": 29, "adelaidermf": 38}

# Section IV-A, "Performance on the Symbench dataset": "the average inlier ratio of initial correspondences on
# this dataset is lower than 10%". An upper bound, in percent.
SYMBENCH_INLIER_RATIO_SOURCE = SOURCE + ", section IV-A"
SYMBENCH_INLIER_RATIO_BELOW = 10.0


def _row(selectors, *values):
    """Return selector -> value."""
    if len(selectors) != len(values):
        raise ValueError("%d selectors, %d values" % (len(selectors), len(values)))
    return dict(zip(selectors, values))


# Table in Fig. 3 (d) (fig:per1, tab:ade). NNSR and GTM do not run there.
ADELAIDE_SOURCE = SOURCE + ", Fig. 3 (d)"
_ADELAIDE = ("ransac", "st", "usac", "vfc", "gms", "lpm")
ADELAIDE = {
    "precision": _row(_ADELAIDE, 93.84, 77.32, 96.28, 97.59, 98.54, 81.21),
    "recall": _row(_ADELAIDE, 68.77, 21.31, 79.13, 87.36, 79.22, 99.62),
    "f": _row(_ADELAIDE, 77.03, 32.18, 84.89, 91.63, 87.25, 88.91),
}

# Table in Fig. 6 (b) (fig:per4, tab:select): F after NNSR.
PRESELECTED_SOURCE = SOURCE + ", Fig. 6 (b)"
_PRESELECTED = ("ransac", "st", "gtm", "usac", "vfc", "gms", "lpm")
PRESELECTED = {
    "symbench": _row(_PRESELECTED, 17.26, 5.06, 18.46, 14.84, 22.37, 26.59, 18.04),
    "heinly": _row(_PRESELECTED, 97.12, 51.20, 58.41, 87.45, 96.16, 70.45, 97.27),
}

# Table III (tab:fea): F; (features, dataset) -> selector -> F. GTM needs affine frames and is not in it.
FEATURES_SOURCE = SOURCE + ", Table III"
_FEATURES = ("nnsr", "ransac", "st", "usac", "vfc", "gms", "lpm")
FEATURES = {
    ("sift+sift", "symbench"): _row(_FEATURES, 9.34, 3.02, 1.22, 3.27, 11.56, 11.64, 9.36),
    ("sift+sift", "heinly"): _row(_FEATURES, 94.13, 95.43, 33.82, 98.75, 83.08, 40.29, 89.84),
    ("orb+orb", "symbench"): _row(_FEATURES, 4.70, 5.27, 2.13, 3.33, 3.00, 11.62, 6.31),
    ("orb+orb", "heinly"): _row(_FEATURES, 57.62, 58.98, 17.57, 56.45, 56.30, 50.24, 60.30),
    ("asift+asift", "symbench"): _row(_FEATURES, 7.00, 7.15, 3.29, 4.54, 14.42, 17.48, 12.54),
    ("asift+asift", "heinly"): _row(_FEATURES, 69.31, 92.31, 27.47, 78.72, 78.75, 44.21, 88.21),
    ("blob+freak", "symbench"): _row(_FEATURES, 4.62, 2.35, 0.95, 1.97, 6.25, 0.50, 2.19),
    ("blob+freak", "heinly"): _row(_FEATURES, 68.63, 76.25, 20.32, 74.45, 68.71, 4.30, 66.64),
}

# Table IV (tab:rob). The cases are VGG's scenes in alphabetical order. The paper's column "UASC" is USAC.
ROBUSTNESS_SOURCE = SOURCE + ", Table IV"
Case = namedtuple("Case", "name scene nuisance precision recall f")


def _case(name, scene, nuisance, precision, recall, f):
    """Return one case of Table IV."""
    return Case(name, scene, nuisance, *(_row(SELECTORS, *values) for values in (precision, recall, f)))


ROBUSTNESS = {
    case.name: case
    for case in (
        _case(
            "case1",
            "bark",
            "zoom and rotation",
            (81.16, 76.11, 17.98, 43.22, 77.38, 67.19, 63.61, 42.50),
            (77.68, 92.86, 4.51, 79.60, 99.05, 86.11, 11.45, 83.54),
            (77.35, 82.42, 6.56, 53.69, 84.48, 74.27, 18.46, 54.75),
        ),
        _case(
            "case2",
            "bikes",
            "blur",
            (74.57, 36.87, 44.23, 67.00, 49.66, 29.44, 41.71, 27.73),
            (79.39, 41.85, 8.23, 56.74, 60.00, 51.41, 50.45, 54.75),
            (71.87, 38.71, 13.46, 61.12, 54.30, 35.27, 45.54, 35.86),
        ),
        _case(
            "case3",
            "boat",
            "zoom and rotation",
            (61.53, 70.54, 15.97, 44.92, 67.41, 49.38, 58.57, 44.59),
            (57.91, 83.28, 1.97, 52.16, 79.95, 99.22, 57.21, 76.43),
            (53.74, 74.81, 3.50, 44.83, 73.12, 61.91, 56.35, 55.10),
        ),
        _case(
            "case4",
            "graf",
            "viewpoint change",
            (51.77, 55.58, 37.21, 50.94, 63.01, 57.86, 57.05, 45.08),
            (61.63, 66.38, 3.52, 68.55, 79.73, 97.08, 75.52, 83.97),
            (51.75, 58.56, 6.41, 55.69, 70.23, 71.23, 64.55, 56.56),
        ),
        _case(
            "case5",
            "leuven",
            "light change",
            (76.28, 81.44, 61.90, 68.90, 83.76, 71.99, 64.89, 57.65),
            (63.75, 86.97, 6.76, 80.35, 100.0, 100.0, 87.95, 84.46),
            (68.00, 82.34, 11.61, 73.94, 91.11, 82.49, 74.37, 67.90),
        ),
        _case(
            "case6",
            "trees",
            "blur",
            (31.90, 45.33, 24.95, 33.45, 32.23, 31.18, 57.10, 26.72),
            (69.13, 27.06, 2.57, 39.10, 40.00, 40.00, 47.00, 66.81),
            (31.49, 28.86, 4.34, 34.29, 35.68, 35.02, 50.80, 35.82),
        ),
        _case(
            "case7",
            "ubc",
            "JPEG compression",
            (89.47, 87.07, 89.46, 80.66, 89.59, 89.48, 79.87, 75.87),
            (61.17, 97.41, 28.59, 94.42, 100.0, 100.0, 96.70, 93.38),
            (72.42, 91.81, 43.07, 86.88, 94.43, 94.26, 87.25, 83.43),
        ),
        _case(
            "case8",
            "wall",
            "viewpoint change",
            (67.27, 74.42, 52.34, 72.05, 73.03, 72.40, 80.86, 62.67),
            (61.08, 79.03, 4.02, 80.12, 80.00, 79.51, 73.10, 81.76),
            (58.39, 76.23, 7.36, 73.42, 76.33, 75.74, 76.08, 69.64),
        ),
    )
}

# Table V (tab:sum), drawn upon F. Its detector and descriptor combinations name no dataset; the curves they are
# read from (Fig. 8, fig:per6) are of VGG.
GUIDE_SOURCE = SOURCE + ", Table V"
Advice = namedtuple("Advice", "group name superior inferior")
GUIDE = {
    "vgg": Advice("Datasets", "VGG", ("usac", "ransac", "vfc"), ("st",)),
    "symbench": Advice("Datasets", "Symbench", ("gms",), ("st", "usac")),
    "heinly": Advice("Datasets", "Heinly", ("ransac", "nnsr", "lpm"), ("st", "gtm", "gms")),
    "adelaidermf": Advice("Datasets", "AdelaideRMF", ("vfc", "lpm"), ("st", "ransac")),
    "nnsr_vgg": Advice("NNSR pre-selection", "VGG", ("usac", "ransac", "lpm"), ("st",)),
    "nnsr_symbench": Advice("NNSR pre-selection", "Symbench", ("gms", "vfc"), ("st",)),
    "nnsr_heinly": Advice("NNSR pre-selection", "Heinly", ("lpm", "ransac", "vfc"), ("st", "gms")),
    "sift+sift": Advice("Det/Des combinations", "SIFT+SIFT", ("usac", "nnsr", "gms"), ("st", "ransac")),
    "orb+orb": Advice("Det/Des combinations", "ORB+ORB", ("lpm", "gms", "usac"), ("st", "vfc")),
    "asift+asift": Advice(
        "Det/Des combinations", "ASIFT+ASIFT", ("vfc", "ransac", "gms"), ("st", "usac", "nnsr")
    ),
    "blob+freak": Advice(
        "Det/Des combinations", "BLOB+FREAK", ("vfc", "nnsr", "ransac"), ("st", "gms", "usac")
    ),
    "zoom_and_rotation": Advice("Robustness", "Zoom and rotation", ("usac", "ransac"), ("st", "gtm", "gms")),
    "blur": Advice("Robustness", "Blur", ("nnsr", "gms"), ("st", "ransac")),
    "viewpoint_change": Advice("Robustness", "Viewpoint change", ("usac", "vfc"), ("st", "nnsr")),
    "light_change": Advice("Robustness", "Light change", ("usac", "vfc"), ("st",)),
    "jpeg_compression": Advice("Robustness", "JPEG compression", ("usac", "vfc"), ("st", "nnsr")),
    "efficiency": Advice("Efficiency", "", ("gms", "nnsr"), ("st", "gtm")),
}

# Fig. 8 (fig:per6): curves on VGG for these combinations; no numbers are printed.
FEATURES_VGG = ("sift+sift", "orb+orb", "asift+asift", "blob+freak")

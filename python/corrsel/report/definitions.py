"""What the terms of the report mean."""
from .selectors import BASELINE
from .words import STATUSES, esc


def definitions(run):
    """Return (term, HTML) of every term the report uses."""
    out = [
        (
            "Putative matches",
            (
                "the nearest neighbour, by descriptor distance, of every left feature in the right image: no"
                " cross-check, no ratio test. <i>Given</i> features are matches that the dataset itself"
                " provides."
            ),
        ),
        (
            "Selector",
            (
                "a method that keeps some of the putative matches. A name such as <code>lpm:v2</code> is the"
                " method <code>lpm</code> with its preset <code>v2</code>; a bare name has the parameters of"
                " the paper."
            ),
        ),
        (
            "Baseline %s" % BASELINE,
            (
                "keeps every match. Its score is that of the matches without selection. It does not compete"
                " for the marks."
            ),
        ),
        (
            "Tolerance \u03c4",
            (
                "the largest error in pixels at which a match counts as correct, 1 to 10 px. The error is the"
                " distance of the right point from where the ground truth sends the left point (forward only;"
                " for a fundamental matrix, from the epipolar line)."
            ),
        ),
        (
            "Ground-truth inliers, t<sub>gt</sub>",
            "the putative matches with an error of at most t<sub>gt</sub> = %s px, whatever \u03c4 is. For"
            " labelled data: the matches labelled as belonging to a structure; there is no \u03c4."
            % run.ground_truth_px(),
        ),
        (
            "Precision",
            (
                "correct selected matches at \u03c4 / selected matches. Undefined, and left empty, where"
                " nothing is selected; recall and F are then 0."
            ),
        ),
        (
            "Recall (paper)",
            "correct selected matches at \u03c4 / ground-truth inliers at t<sub>gt</sub> = %s px. The"
            " denominator does not shrink with \u03c4, so even a perfect selection has a recall below 1 at"
            " small \u03c4." % run.ground_truth_px(),
        ),
        (
            "Recall (same \u03c4)",
            "correct selected matches at \u03c4 / putative matches within the same \u03c4.",
        ),
        (
            "F",
            (
                "harmonic mean of precision and recall (paper) of a pair; <i>F, same \u03c4</i> takes recall"
                " (same \u03c4)."
            ),
        ),
        (
            "Mean F",
            (
                "mean over the pairs of their F, not the F of mean precision and mean recall. The same holds"
                " for precision and recall. Pairs without any ground-truth inlier are left out and listed."
            ),
        ),
        (
            "Interval",
            (
                "95 % bootstrap interval of the mean F: pairs are resampled with replacement. If two"
                " intervals do not overlap, the selectors differ. If they overlap, the question remains open."
                " All selectors are given the same pairs, so <i>better on</i> (the number of pairs on which"
                " the winner has a higher F than the runner-up) can be more conclusive."
            ),
        ),
        (
            "Selection time",
            (
                "wall time of the selector alone, from the putative matches to the mask, steady clock."
                " Detection, description and matching are not in it, nor is a preselection. Median and 95th"
                " percentile (p95) over the pairs. It depends on the machine described below."
            ),
        ),
        (
            "Confidence",
            (
                "-log<sub>10</sub> of the number of agreements as good as that of the selected matches that are"
                " expected if all matches were wrong: 20 means that one such agreement is expected in 10<sup>20</sup>"
                " selections. 0 means that chance explains it. Tables show the median over the pairs."
            ),
        ),
        (
            "Preselection",
            (
                "with <code>nnsr</code>, the survivors of NNSR (nearest-neighbour similarity ratio) become"
                " the putative matches, and the ground-truth inliers are counted again among them: recall is"
                " relative to the survivors."
            ),
        ),
    ]
    if "sample" in run.datasets:
        out.append(
            (
                "Dataset sample",
                (
                    "all sequences but <i>graf</i> and <i>aloe</i> are generated: the right image is computed"
                    " from a photograph by a known homography. Results on generated pairs show how a"
                    " method copes with geometry rather than with a real second photograph."
                ),
            )
        )
    statuses = "; ".join("<code>%s</code>: %s" % (name, esc(text)) for name, text in STATUSES.items())
    out.append(("Status", statuses + "."))
    return out


def html(run, figures):
    """Return the body of the section."""
    return "<dl>%s</dl>" % "".join("<dt>%s</dt><dd>%s</dd>" % item for item in definitions(run))

"""What the terms of the report mean."""
from .markup import render
from .selectors import BASELINE
from .words import STATUSES


def html(run, figures):
    """Return the body of the section."""
    return render(
        "definitions.html",
        baseline=BASELINE,
        ground_truth_px=run.ground_truth_px(),
        statuses=STATUSES,
        sample="sample" in run.datasets,
    )

"""What the terms of the report mean."""
from .markup import render
from .selectors import BASELINE
from .scenes import counts_of
from .words import SCENES, STATUSES, photographed_text


def html(run, figures):
    """Return the body of the section."""
    return render(
        "definitions.html",
        baseline=BASELINE,
        ground_truth_px=run.ground_truth_px(),
        statuses=STATUSES,
        scenes=SCENES if counts_of(run) else {},
        photographed=photographed_text() if "sample" in run.datasets else "",
    )

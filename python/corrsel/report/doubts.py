"""Which ground truth contradicts the images, above everything else."""
from .markup import sources
from .words import esc

MAX_SHOWN = 12  # the rest stays in summary.json


def html(run, figures=None):
    """Return the warnings about the ground truth; empty where there are none."""
    warnings = [w for w in run.truth_warnings if isinstance(w, dict) and w.get("text")]
    if not warnings:
        return ""
    items = "".join("<li>%s</li>" % esc(w["text"]) for w in warnings[:MAX_SHOWN])
    rest = len(warnings) - MAX_SHOWN
    items += "<li>%d more in summary.json</li>" % rest if rest > 0 else ""
    return (
        '<aside class="state banner" aria-label="Doubtful ground truth"><p><strong>Doubtful ground truth</strong>:'
        " another reading of it explains far more of the matches. Precision, recall and F of these sequences"
        " do not measure the selectors until the data is corrected.</p><ul>%s</ul>%s</aside>"
        % (items, sources(run, "truth_check.csv", "summary.json"))
    )

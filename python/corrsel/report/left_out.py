"""Why pairs are not in the means."""
from collections import Counter, namedtuple

from .words import be, plural

LeftOut = namedtuple("LeftOut", "cause putative")
LeftOut.__doc__ = "Why the recall on a pair cannot be computed, and its number of putative matches."


def cause(row):
    """Return why a row of pairs.csv without ground-truth inlier has none, as words that follow "has"."""
    if row["n_putative"]:
        if row["truth"] == "none":
            return "no ground truth"
        return "no correct putative match"
    if row["preselection"] not in ("", "none") and row["n_left"] and row["n_right"]:
        return "no match after preselection by %s" % row["preselection"]
    empty = [side for side in ("left", "right") if row["n_" + side] == 0]
    if row["features"] == "given" or not empty:
        return "no putative match"
    return "no features in %s" % ("either image" if len(empty) == 2 else "the %s image" % empty[0])


def left_out_sentence(run, group):
    """Return how many pairs of a group are not in its means, and why; "" where all are."""
    counts = Counter(left.cause for (where, _, _), left in run.left_out.items() if where == group)
    reasons = [
        "%d %s %s" % (count, "has" if count == 1 else "have", words) for words, count in counts.most_common()
    ]
    failed = run.failed_pairs(group.dataset)
    if failed:
        reasons.append("%d failed (failures.csv)" % failed)
    if not reasons:
        return ""
    left = sum(counts.values()) + failed
    return "%d of %s %s not in the means: %s." % (
        left,
        plural(run.pair_count(group) + failed, "pair"),
        be(left),
        ", ".join(reasons),
    )

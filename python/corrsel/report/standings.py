"""Who won in a group, for the report's first table and for the terminal."""
from collections import namedtuple

from .selectors import is_baseline
from .words import overlap

Standing = namedtuple("Standing", "first second common wins ties count fastest baseline")
Standing.__doc__ = """The result of a group; its rows are those of summary.csv at the tabulated tolerance.

first, second   the rows with the highest mean F and the one after it; None where there is none
common          whether their intervals overlap; None where one of them is undefined
wins, ties, count   pairs on which the first has the higher F, on which they have the same, and all that both share
fastest         the row with the lowest median time of those that have a mean F
baseline        the row of the baseline, which does not compete
"""


def standing(run, group):
    """Return the Standing of a group."""
    ranking, tau = run.ranking(group), run.tau(group)
    first = ranking[0] if ranking else None
    second = ranking[1] if len(ranking) > 1 else None
    wins, ties, count = (
        run.head_to_head(group, first["selector"], second["selector"]) if second else (0, 0, 0)
    )
    timed = [row for row in ranking if row["select_s_median"] is not None]
    base = [run.mean(group, s, tau) for s in run.selectors_of(group) if is_baseline(s)]
    return Standing(
        first,
        second,
        overlap(first, second) if second else None,
        wins,
        ties,
        count,
        min(timed, key=lambda row: row["select_s_median"]) if timed else None,
        next((row for row in base if row), None),
    )

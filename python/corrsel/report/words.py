"""Numbers and names as words; nothing here is HTML."""


STATUSES = {
    "ok": "a selection was made",
    "too_few": "fewer matches than the method needs; nothing selected",
    "degenerate": "the matches (all equal, or on one line) cannot decide the model",
    "no_model": "the search ended without a model",
    "unsupported_input": "the input lacks something the method needs, such as descriptor distances",
    "too_large": "more matches than the memory or time options allow",
    "time_limit": "stopped at its time limit; the best result until then counts",
    "failed": "the method reported an internal error",
    "uncertain": "a selection was made, but its confidence is below min_confidence",
}
SCENES = {
    "nothing": "neither a model nor the local agreement is significant",
    "at_rest": "one homography explains the matches, which hardly move",
    "plane_or_rotation": "one homography explains the matches: a plane, or a camera that only turns",
    "rigid": "one fundamental matrix explains the matches: a rigid scene with depth",
    "several_motions": "groups of matches move by themselves",
    "unknown": "there is agreement, but no significant model",
}
# Sequences of the dataset "sample" whose second image is a photograph too.
PHOTOGRAPHED = ("graf", "aloe", "rig", "box", "page")
UNRELATED = "unrelated_"  # begins the name of a dataset of pairs of different scenes
GIVEN = "given"  # features of a dataset that provides matches


def plural(count, noun, many=None):
    """Return '1 pair', '2 pairs'."""
    return "%d %s" % (count, noun if count == 1 else many or noun + "s")


def be(count):
    """Return the verb that goes with a count."""
    return "is" if count == 1 else "are"


def number(value, missing="\u2013"):
    """Return a count or a plain number as text."""
    return missing if value is None else "%g" % value if abs(value) < 1e6 else "%d" % value


def tenths(value, missing="\u2013"):
    """Return a number with one decimal."""
    return missing if value is None else "%.1f" % value


def fraction(value, missing="\u2013"):
    """Return a fraction with three decimals."""
    return missing if value is None else "%.3f" % value


def milliseconds(seconds, missing="\u2013"):
    """Return a duration given in seconds as milliseconds with about three digits."""
    if seconds is None:
        return missing
    ms = 1e3 * seconds
    if 0 < ms < 0.001:
        return "<0.001"
    return "%.*f" % (0 if ms >= 1000 else 1 if ms >= 10 else 2 if ms >= 1 else 3, ms)


def interval(row):
    """Return the bootstrap interval of the mean F of a row of summary.csv as text."""
    return span(row["f_paper_lo"], row["f_paper_hi"])


def with_interval(row):
    """Return the mean F of a row of summary.csv as text, with its interval where it has one."""
    value = fraction(row["f_paper"])
    return value if None in (row["f_paper_lo"], row["f_paper_hi"]) else "%s (%s)" % (value, interval(row))


def span(low, high, show=fraction):
    """Return the bounds of an interval as text; a dash where one is undefined."""
    return "\u2013" if None in (low, high) else "%s\u2013%s" % (show(low), show(high))


def overlap(first, second):
    """Tell whether two intervals overlap; None where one of them is undefined."""
    bounds = [row[k] for row in (first, second) for k in ("f_paper_lo", "f_paper_hi")]
    if None in bounds:
        return None
    return bounds[0] <= bounds[3] and bounds[2] <= bounds[1]


def is_unrelated(dataset):
    """Tell whether the pairs of a dataset show different scenes."""
    return dataset.startswith(UNRELATED)


def photographed_text():
    """Return the names of the sequences of the dataset "sample" that are not generated, as words."""
    return "%s and %s" % (", ".join(PHOTOGRAPHED[:-1]), PHOTOGRAPHED[-1])


def data_kind(dataset):
    """Return whether a dataset's pairs are real, reconstructed or generated, as words."""
    if dataset == "sample":
        return "generated but for " + photographed_text()
    for kind in ("reconstructed", "generated"):
        if dataset.endswith("_" + kind):
            return kind
    return "real"


def kind_text(dataset):
    """Return the kind of a dataset as words that stand alone."""
    kind = data_kind(dataset)
    return kind if " " in kind else kind + " data"


def dataset_text(dataset):
    """Return a dataset's name, with a remark if its pairs are not real."""
    kind = data_kind(dataset)
    return dataset if kind == "real" else "%s (%s)" % (dataset, kind)


def at_tau(tau):
    """Return the tolerance as words."""
    return "labelled ground truth" if tau is None else "\u03c4 = %g px" % tau


def preselection_text(name):
    """Return the preselection as words."""
    return "no preselection" if name in ("", "none") else "after preselection by %s" % name


def group_text(group):
    """Return the name of a group as words."""
    return "%s, %s, %s" % (
        dataset_text(group.dataset),
        features_text(group.features),
        preselection_text(group.preselection),
    )


def features_text(name):
    """Return the features as words."""
    return "given matches" if name == GIVEN else name


def statuses_text(counts):
    """Return the statuses of a selector as words, most frequent first."""
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return ", ".join("%s (%d)" % (name.replace("_", " "), count) for name, count in ordered)

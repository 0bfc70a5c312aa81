"""What the run noticed about its input, in words."""


def remark_sentences(run):
    """Return one sentence per remark of remarks.csv; equal ones on several datasets are put together."""
    places = {}
    for row in run.remarks:
        place = "/".join(filter(None, (row["dataset"], row["sequence"])))
        places.setdefault((row["selector"], row["remark"]), {})[place] = None
    out = []
    for (selector, remark), where in places.items():
        names = ", ".join(filter(None, where))
        if selector:
            out.append("%s does not run%s: %s." % (selector, " on %s" % names if names else "", remark))
        else:
            out.append("%s%s." % (names + ": " if names else "", remark))
    return out

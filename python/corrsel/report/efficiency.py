"""Section on efficiency: selection time against the number of matches, and against F."""
from collections import Counter

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from . import paper
from .figures import draw_part, edge_of, line_figures, new_axes, part_ending
from .markup import DASH, LOWEST, bold, compared_cell, findings, group_heading, heading, joined, panels
from .markup import paragraph, row_class, selector_name, small, table, with_headings
from .selectors import is_baseline, selector_key, selector_styles
from .timing import time_panel
from .words import milliseconds, plural, span

# Statuses of calls that did not do the work, so that their times mean nothing.
NOT_TIMED = ("too_few", "too_large", "unsupported_input", "failed")


def threads_key(threads):
    """Sort key of a number of threads as text: numbers first, by value."""
    return (not threads.isdigit(), int(threads) if threads.isdigit() else 0, threads)


def scaling_times(run):
    """Return threads -> selector -> n -> seconds of each round, from scaling.csv; calls that did no work left out."""
    times = {}
    for row in run.scaling:
        if row["status"] in NOT_TIMED or None in (row["n"], row["select_s"]):
            continue
        selectors = times.setdefault(row["threads"], {})
        selectors.setdefault(row["selector"], {}).setdefault(int(row["n"]), []).append(row["select_s"])
    return {
        threads: {
            selector: dict(sorted(times[threads][selector].items()))
            for selector in sorted(times[threads], key=selector_key)
        }
        for threads in sorted(times, key=threads_key)
    }


def untimed(run):
    """Return (selector, status) -> number of calls that did not do the work."""
    counts = Counter((r["selector"], r["status"]) for r in run.scaling if r["status"] in NOT_TIMED)
    return dict(sorted(counts.items(), key=lambda item: (selector_key(item[0][0]), item[0][1])))


def growth_exponent(rounds):
    """Return p of the least-squares fit time = c n^p through the medians, on logarithms; None with fewer than two.

    `rounds` is n -> seconds of each round.
    """
    points = [(n, float(np.median(seconds))) for n, seconds in rounds.items()]
    points = [(np.log(n), np.log(median)) for n, median in points if n > 0 and median > 0]
    if len(points) < 2:
        return None
    x, y = np.array(points).T
    x = x - x.mean()
    return float((x * y).sum() / (x * x).sum())


def threads_text(threads):
    """Return a number of threads as words."""
    return "1 thread" if threads == "1" else "%s threads" % threads


def medians_at(selectors, n):
    """Return competing selector -> median seconds at n, fastest first."""
    found = {s: float(np.median(r[n])) for s, r in selectors.items() if n in r and not is_baseline(s)}
    return dict(sorted(found.items(), key=lambda item: (item[1], selector_key(item[0]))))


def statement(threads, selectors):
    """Return who is fastest and slowest at the largest n, as a sentence; '' with fewer than two selectors."""
    n = max((n for rounds in selectors.values() for n in rounds), default=None)
    medians = medians_at(selectors, n)
    if len(medians) < 2:
        return ""
    names = list(medians)
    timed = [Markup("<b>%s</b> (%s ms)") % (s, milliseconds(medians[s])) for s in names]
    text = Markup("%s, N = %d: <b>%s</b> is fastest (%s ms)") % (
        threads_text(threads),
        n,
        names[0],
        milliseconds(medians[names[0]]),
    )
    if len(names) > 3:
        text += Markup(", then %s; slowest are %s and %s") % (timed[1], timed[-1], timed[-2])
    else:
        text += Markup("; slowest is %s") % timed[-1]
    if medians[names[0]] > 0:
        text += ": %s times the fastest" % ratio_text(medians[names[-1]] / medians[names[0]])
    exponents = {s: growth_exponent(selectors[s]) for s in names}
    exponents = {s: p for s, p in exponents.items() if p is not None}
    if len(exponents) > 1:
        steep, flat = max(exponents, key=exponents.get), min(exponents, key=exponents.get)
        text += Markup(
            ". The time of <b>%s</b> grows most steeply, as N<sup>%.2f</sup>, that of <b>%s</b> least, as N<sup>%.2f</sup>"
        ) % (steep, exponents[steep], flat, exponents[flat])
    absent = [s for s in selectors if s not in medians and not is_baseline(s)]
    if absent:
        text += Markup(". Without a time at this N: %s") % joined(map(bold, absent), ", ")
    return text + "."


def ratio_text(ratio):
    """Return a ratio with about two digits."""
    return "%.0f" % ratio if ratio >= 9.95 else "%.1f" % ratio


def scaling_panel(run, figures, threads, selectors, part):
    """Draw the median time against n on a logarithmic axis, with the quartiles of the rounds as bars."""
    figure, axes = new_axes(5.0, 3.8, 0.62, 0.15, 0.5, 0.34)

    def line_of(selector, named):
        ns = list(selectors[selector])
        quartiles = np.array([np.percentile(selectors[selector][n], [25, 50, 75]) for n in ns]) * 1e3
        quartiles = np.maximum(quartiles, 1e-6)  # a time of 0 has no place on the axis
        if named:
            edge = edge_of(run.styles[selector])
            axes.vlines(ns, quartiles[:, 0], quartiles[:, 2], color=edge, linewidth=1.2)
        return ns, quartiles[:, 1]

    draw_part(axes, run, part, line_of)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(base=10))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: "%g" % y))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.set_xlabel("number of matches N")
    axes.set_title("Selection time (ms), %s" % threads_text(threads), loc="left")
    axes.grid(True)
    label = "Selection time against the number of matches, %s, one line per selector" % threads_text(threads)
    return figures(figure, label, "scaling_%s_threads%s" % (threads, part_ending(part)))


def scaling_table(threads, selectors):
    """Return the table of median times for a number of threads."""
    ns = sorted({n for rounds in selectors.values() for n in rounds})
    fastest = {n: next(iter(medians_at(selectors, n).values()), None) for n in ns}
    rows = []
    for selector in sorted(selectors, key=selector_key):
        rounds, base = selectors[selector], is_baseline(selector)
        cells = [selector_name(selector)]
        for n in ns:
            cells.append(time_cell(rounds.get(n), None if base else fastest[n]))
        last = rounds.get(ns[-1])
        cells.append(span(*np.percentile(last, [25, 75]), milliseconds) if last else DASH)
        exponent = growth_exponent(rounds)
        cells.append(DASH if exponent is None else "%.2f" % exponent)
        cells.append(
            DASH if base or not last or not fastest[ns[-1]] else ratio_text(np.median(last) / fastest[ns[-1]])
        )
        rows.append((selector, (row_class(selector), cells)))
    head = ["Selector"] + ["N = %d" % n for n in ns]
    head += ["Quartiles", "Exponent", "\u00d7 fastest"]
    count = max(len(seconds) for rounds in selectors.values() for seconds in rounds.values())
    caption = Markup(
        "Selection time in ms, %s: median of %s; quartiles at N = %d. Exponent: p of the fit time \u221d N<sup>p</sup>"
        " through the medians. \u00d7 fastest: median over the lowest at N = %d. \u25bc lowest of the column."
    ) % (threads_text(threads), plural(count, "round"), ns[-1], ns[-1])
    return table(caption, head, with_headings(rows), "results")


def time_cell(seconds, best):
    """Return the cell of a median time, marked where it shows the same text as the lowest one."""
    if not seconds:
        return DASH
    return compared_cell(milliseconds(float(np.median(seconds))), best and milliseconds(best), LOWEST)


def gain_table(threads, selectors, single):
    """Return the table of the times of selectors that use several threads, and of what they gain.

    `single` is selector -> n -> seconds of each round with one thread.
    """
    ns = sorted({n for rounds in selectors.values() for n in rounds})
    rows = []
    for selector, rounds in selectors.items():
        cells = [selector]
        for n in ns:
            before = single.get(selector, {}).get(n)
            if not rounds.get(n) or not before:
                cells.append(DASH)
                continue
            time = float(np.median(rounds[n]))
            gain = "%.2f" % (np.median(before) / time) if time > 0 else DASH
            cells.append(joined([milliseconds(time), small("(%s)" % gain)], " "))
        rows.append(("", cells))
    caption = (
        "Selection time in ms with %s, of the selectors that use several threads: median over the rounds. In brackets:"
        " the time with one thread divided by this time." % threads_text(threads)
    )
    return table(caption, ["Selector"] + ["N = %d" % n for n in ns], rows, "results")


def scaling_html(run, figures):
    """Return statement, curves and tables of the time against the number of matches.

    All selectors are compared with one thread (or the lowest number there is). Higher numbers are shown only beside
    it, for the selectors that were measured with them.
    """
    times = scaling_times(run)
    if not times:
        return paragraph(
            "Time against the number of matches was not measured: scaling.csv is absent or empty (the experiment"
            " efficiency writes it)."
        )
    threads, single = next(iter(times.items()))
    out = []
    sentence = statement(threads, single)
    if sentence:
        out.append(findings([sentence]))
    for name in single:  # scaling.csv may name a selector that pairs.csv does not
        run.styles.setdefault(name, selector_styles([name])[name])
    caption = (
        "Median time of select() over the rounds, bars from the lower to the upper quartile; generated matches, half of"
        " them inliers. The time axis is logarithmic."
    )
    out.append(
        line_figures(
            run,
            figures,
            sorted(single, key=selector_key),
            lambda part: [scaling_panel(run, figures, threads, single, part)],
            "panels two",
            caption,
        )
    )
    out.append(scaling_table(threads, single))
    for more, selectors in list(times.items())[1:]:
        out.append(gain_table(more, selectors, single))
    left = [
        "%s (%s: %d)" % (selector, status.replace("_", " "), count)
        for (selector, status), count in untimed(run).items()
    ]
    if left:
        out.append(paragraph("Calls that did not do the work are left out: %s." % ", ".join(left), "small"))
    return joined(out)


def panels_html(run, figures):
    """Return the panels of mean F against time, one for each dataset with the paper's features."""
    out = []
    for group in run.groups:
        if group.preselection != "none" or group.features not in (paper.FEATURES_DEFAULT, "given"):
            continue
        plot = time_panel(run, figures, group)
        if plot:
            out.append(Markup("<h4>%s</h4>%s") % (group_heading(group), plot))
    if not out:
        return ""
    return heading("Time against F") + panels(
        out,
        "Mean F with its 95 % interval against the median selection time on each dataset. Up and to the left is better;"
        " the F axis does not start at 0.",
        "panels two",
    )


def html(run, figures):
    """Return the body of the section on efficiency."""
    intro = paragraph(
        "The paper shows its times as curves only (%s, Figs. 10 and 11), and it times OpenCV and MATLAB programs separately."
        " Only the order of the selectors can be compared, which the guide does." % paper.SOURCE
    )
    return joined([intro, scaling_html(run, figures), panels_html(run, figures)])

"""Experiment visual: drawn matches, pairs by selectors, with successes and failures named (the paper's Fig. 12)."""
import base64
import itertools
from collections import namedtuple
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from .markup import dataset_html, heading, joined, paragraph, render, sources, table, text_cell, with_details
from .reading import at_tolerance, group_of
from .selectors import is_baseline, selector_key
from .words import PHOTOGRAPHED, at_tau, features_text, plural, preselection_text

SUCCESS_F = 0.8  # F from which a drawn pair counts as a success
FAILURE_GAP = 0.3  # F below the best selector's from which it counts as a failure ...
FAILURE_BEST = 0.5  # ... where the best selector has at least this F
MAX_EMBEDDED = 60  # images in the page; successes and failures first, the others are linked
MAX_BYTES = 17e6  # of the embedded images, before they grow by a third in base64

KINDS = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png"}

# A drawn image: its place in the index, its row there, F of pairs.csv, and the best competing image of the pair.
Drawn = namedtuple("Drawn", "index row f best_selector best_f")


def image_path(run, name):
    """Return the path of an image inside the run's folder, None where it is missing, elsewhere or no picture."""
    root = run.folder.resolve()
    for path in (run.folder / "images" / name, run.folder / name):
        try:
            path = path.resolve()
            if root in path.parents and path.suffix.lower() in KINDS and path.is_file():
                return path
        except (OSError, ValueError):
            pass
    return None


def image_data(path):
    """Return an image as a data URI."""
    code = base64.b64encode(path.read_bytes()).decode("ascii")
    return "data:image/%s;base64,%s" % (KINDS[path.suffix.lower()], code)


def image_caption(row, f=None):
    """Return the caption of an example as text, made of its numbers."""
    selected, correct, wrong, missed = (row[k] for k in ("n_selected", "n_correct", "n_wrong", "n_missed"))
    if selected is None:
        return "no counts"
    text = "%d selected" % selected
    if correct is not None:
        share = " (%.1f %%)" % (100 * correct / selected) if selected else ""
        text += ": %s%s" % (plural(int(correct), "inlier"), share)
    text += ", %s" % plural(int(wrong), "outlier") if wrong is not None else ""
    text += "; %s missed" % plural(int(missed), "inlier") if missed is not None else ""
    return text + ("; F %.3f" % f if f is not None else "")


def pair_of(row):
    """Return what names the pair a row is about, in its setting."""
    return (group_of(row), row["sequence"], row["pair"])


def drawn_f(run, row):
    """Return the F of what a row of the index shows; None where there is none."""
    rows = run.rows(group_of(row), row["selector"])
    place = run.pairs.place(row["dataset"], row["sequence"], row["pair"])
    values = rows["f_paper"][(rows["place"] == place) & at_tolerance(rows, row["tau_px"])]
    values = values[np.isfinite(values)]
    return sum(values.tolist()) / len(values) if len(values) else None


def drawn_images(run):
    """Return the Drawn images, by pair in the index's order, selectors in the report's order."""
    pairs = {}
    for row in run.images:
        pairs.setdefault(pair_of(row), []).append(row)
    out = []
    for pair, rows in pairs.items():
        rows = sorted(rows, key=lambda r: selector_key(r["selector"]))
        f = {}
        for row in rows:
            f[row["selector"]] = drawn_f(run, row)
        known = [s for s in f if f[s] is not None and not is_baseline(s)]
        best = max(known, key=lambda s: f[s]) if known else None
        for row in rows:
            out.append(Drawn(len(out) + 1, row, f[row["selector"]], best, f[best] if best else None))
    return out


def is_success(drawn):
    """Tell whether a drawn selection is good in itself."""
    return drawn.f >= SUCCESS_F


def is_failure(drawn):
    """Tell whether a drawn selection is far worse than another selector's where a good one was possible."""
    return drawn.best_f >= FAILURE_BEST and drawn.best_f - drawn.f >= FAILURE_GAP


def findings(images):
    """Return selector -> (its success, its failure), Drawn; the failure is None where it is never behind.

    The success is the pair of its highest F, the failure that of its largest shortfall against the best selector,
    far ones (see is_failure) before others.
    """
    out = {}
    for selector in sorted({d.row["selector"] for d in images}, key=selector_key):
        own = [d for d in images if d.row["selector"] == selector and d.f is not None]
        if is_baseline(selector) or not own:
            continue
        success = max(own, key=lambda d: (d.f, -d.index))
        failure = max(own, key=lambda d: (is_failure(d), d.best_f - d.f, -d.index))
        out[selector] = (success, failure if failure.best_f > failure.f else None)
    return out


def place_text(row):
    """Return the name of a drawn pair."""
    return "%s/%s" % (row["dataset"], " ".join(part for part in (row["sequence"], row["pair"]) if part))


def counts_text(row):
    """Return how many of the inliers a drawn selection keeps, as the rest of a sentence."""
    correct, missed, selected = row["n_correct"], row["n_missed"], row["n_selected"]
    if None in (correct, missed, selected):
        return ""
    text = "keeps %d of %s" % (correct, plural(int(correct + missed), "inlier"))
    wrong = selected - correct if row["n_wrong"] is None else row["n_wrong"]
    return text + " and %s" % plural(int(wrong), "outlier")


def success_sentence(drawn):
    """Return what a selector's success is, in words."""
    name = "success" if is_success(drawn) else "best drawn pair, yet below F %.1f" % SUCCESS_F
    text = "%s on %s: %s: %s (F %.3f)" % (
        drawn.row["selector"],
        place_text(drawn.row),
        name,
        counts_text(drawn.row) or "no counts",
        drawn.f,
    )
    if drawn.best_f > drawn.f:
        text += "; best there is %s with F %.3f" % (drawn.best_selector, drawn.best_f)
    return text + "."


def failure_sentence(selector, drawn):
    """Return what a selector's failure is, in words."""
    if drawn is None:
        return "%s: no other selector is better on any drawn pair." % selector
    name = "failure" if is_failure(drawn) else "largest shortfall, no failure"
    if is_failure(drawn) is False and drawn.best_f < FAILURE_BEST:
        name = "largest shortfall, where no selector reaches F %.1f" % FAILURE_BEST
    return "%s on %s: %s: %s (F %.3f) while %s reaches F %.3f." % (
        selector,
        place_text(drawn.row),
        name,
        counts_text(drawn.row) or "no counts",
        drawn.f,
        drawn.best_selector,
        drawn.best_f,
    )


def findings_html(images):
    """Return the table of each selector's success and failure, with links to the images."""
    rows = []
    for selector, (success, failure) in findings(images).items():
        own = [d for d in images if d.row["selector"] == selector and d.f is not None]
        cells = [selector]
        for sentence, drawn in (
            (success_sentence(success), success),
            (failure_sentence(selector, failure), failure),
        ):
            link = Markup(' <a class="nb" href="#cell-%d">see it</a>') % drawn.index if drawn else ""
            cells.append(text_cell(sentence + link))
        successes = plural(sum(map(is_success, own)), "success", "successes")
        cells.append("%s, %s of %d" % (successes, plural(sum(map(is_failure, own)), "failure"), len(own)))
        rows.append(("", cells))
    if not rows:
        return ""
    caption = (
        "A success and a failure of each selector among the drawn pairs. Success: F of at least %.1f, or else the"
        " selector's best drawn pair. Failure: F at least %.1f below the best selector's where that reaches"
        " %.1f, or else the largest shortfall. Last column: how many of the selector's drawn pairs are one or the other."
    ) % (SUCCESS_F, FAILURE_GAP, FAILURE_BEST)
    head = ["Selector", "Success", "Failure", "Number"]
    return table(caption, head, rows, "texts findings", long=True)


def embedded(run, images):
    """Return index -> path of the images that go into the page: successes and failures first."""
    named = [d for pair in findings(images).values() for d in pair if d]
    out, size = {}, 0
    for drawn in named + images:
        path = image_path(run, drawn.row["file"])
        if path is None or drawn.index in out or len(out) >= MAX_EMBEDDED:
            continue
        if size + path.stat().st_size <= MAX_BYTES:
            out[drawn.index] = path
            size += path.stat().st_size
    return out


def verdict(drawn):
    """Return class and name of a success or a failure; None otherwise, and for the baseline."""
    if drawn.f is None or is_baseline(drawn.row["selector"]):
        return None
    if is_failure(drawn):
        return "bad", "failure"
    return ("good", "success") if is_success(drawn) else None


def example(run, drawn, path):
    """Return what the template shows of one image: embedded, linked, or a word that it is missing."""
    row, file = drawn.row, image_path(run, drawn.row["file"])
    parts = file.relative_to(run.folder.resolve()).parts if file else ()
    return {
        "index": drawn.index,
        "selector": row["selector"],
        "title": "%s on %s %s %s" % (row["selector"], row["dataset"], row["sequence"], row["pair"]),
        "file": row["file"],
        "data": image_data(path) if path else "",
        "link": run.link + "/".join(map(quote, parts)) if file else "",
        "caption": image_caption(row, drawn.f),
        "verdict": verdict(drawn),
    }


def pair_heading(row):
    """Return the heading of a drawn pair."""
    group, tau = group_of(row), at_tau(row["tau_px"])
    if group.dataset == "sample":
        tau += ", photographed" if row["sequence"] in PHOTOGRAPHED else ", generated"
    details = "%s, %s, %s" % (features_text(group.features), preselection_text(group.preselection), tau)
    head = dataset_html(group.dataset) if group.dataset != "sample" else group.dataset
    name = [head] + [part for part in (row["sequence"], row["pair"]) if part]
    return heading(with_details(joined(name, " / "), details))


LEGEND = (
    ("#009E73", "inlier", "selected and within \u03c4 of the truth"),
    ("#D55E00", "outlier", "selected, but further than \u03c4 from the truth"),
    ("#0072B2", "missed", "an inlier that is not selected"),
    ("#F0E442", "truth unknown", "selected where there is no ground truth"),
)


def html(run, figures):
    """Return the body of the section."""
    if not run.images:
        return paragraph("The run drew no example pairs.")
    images = drawn_images(run)
    paths = embedded(run, images)
    return render(
        "visual.html",
        legend=LEGEND,
        findings=findings_html(images),
        sources=sources(run, "images/index.csv", "pairs.csv"),
        some_linked=any(d.index not in paths and image_path(run, d.row["file"]) for d in images),
        embedded=len(paths),
        drawn=len(images),
        pairs=[
            (pair_heading(rows[0].row), [example(run, drawn, paths.get(drawn.index)) for drawn in rows])
            for rows in (list(rows) for _, rows in itertools.groupby(images, lambda d: pair_of(d.row)))
        ],
    )

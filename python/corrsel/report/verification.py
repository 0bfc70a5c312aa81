"""Writes the page about a run of corrsel_verify, one self-contained HTML file.

Usage: python3 -m corrsel.report.verification PAIRS_CSV SUMMARY_JSON PAGE_HTML

Reads the files that `corrsel_verify --report` writes. The same files always give the same bytes. Exit status: 0 if the
page could be made, else 2.
"""
import csv
import json
import re
import sys
from collections import Counter, namedtuple
from pathlib import Path

from .tables import ReportError

PROGRAM = "corrsel.report.verification"
MOST_HOVERED = 300000  # pairs of a page that shows numbers under the pointer; more would make it too large
MOST_LABELS = 60  # images whose names all stand beside the matrix
ROWS = 20  # of a table of examples
AMBIGUOUS = 0.5  # pairs from this ambiguity on are listed

COLUMNS = "image1 image2 raw kept status confidence config ambiguity message".split()
Pair = namedtuple("Pair", COLUMNS)
TRACK_TEXTS = (
    ("tracks", "tracks"),
    ("observations", "keypoints in tracks"),
    ("mean_length", "keypoints of a track, mean"),
    ("matches", "verified matches"),
    ("cut", "of these, cut because two keypoints of one image would meet"),
)
CYCLE_TEXTS = (
    ("triplets", "triplets of images"),
    ("failing", "of these, whose rotations do not close"),
    ("accused", "pairs that they accuse"),
    ("unchecked", "pairs without a triplet"),
)


def number(text):
    """Return a field as a number; None where it is empty."""
    return float(text) if text else None


def read_pairs(path):
    """Read pairs.csv; ReportError where it is no such file."""
    pairs = []
    try:
        with open(str(path), newline="", encoding="utf-8", errors="replace") as stream:
            rows = csv.reader(stream)
            if next(rows, None) != COLUMNS:
                raise ReportError(
                    "%s: the first line is not %s. Remedy: give the file that corrsel_verify --report has written."
                    % (path, ",".join(COLUMNS))
                )
            for row in rows:
                if len(row) != len(COLUMNS):
                    raise ReportError(
                        "%s: line %d has %d fields instead of %d. Remedy: write the report again."
                        % (path, rows.line_num, len(row), len(COLUMNS))
                    )
                pair = Pair(*row)
                pairs.append(
                    pair._replace(
                        raw=int(pair.raw or 0),
                        kept=int(pair.kept or 0),
                        confidence=number(pair.confidence),
                        ambiguity=number(pair.ambiguity),
                    )
                )
    except (OSError, ValueError) as error:
        raise ReportError(
            "%s: cannot be read (%s). Remedy: write the report again." % (path, error)
        ) from error
    return pairs


def read_summary(path):
    """Read summary.json; ReportError where that fails."""
    try:
        return json.loads(Path(str(path)).read_text(encoding="utf-8", errors="replace"))
    except (OSError, ValueError) as error:
        raise ReportError(
            "%s: cannot be read (%s). Remedy: write the report again." % (path, error)
        ) from error


def natural(name):
    """Return the key that sorts image9 before image10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


def kind_of(pair):
    """Return the name of a pair's kind in the legend of the matrix."""
    if pair.status == "faulty":
        return "faulty"
    return "rejected" if pair.config == "undefined" else pair.config


def is_accepted(pair):
    """Tell whether the images of a pair show the same scene."""
    return kind_of(pair) not in ("faulty", "rejected")


def connected_groups(names, pairs):
    """Return the sizes of the groups of images that accepted pairs connect, the largest first."""
    parent = {name: name for name in names}

    def root(name):
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    for pair in pairs:
        if is_accepted(pair):
            parent[root(pair.image1)] = root(pair.image2)
    return sorted(Counter(root(name) for name in names).values(), reverse=True)


def value_text(value, digits=2):
    """Return a number as text; a dash for None."""
    return "\u2013" if value is None else "%.*f" % (digits, value)


def pair_rows(pairs):
    """Return the rows of a table of pairs."""
    from .markup import text_cell

    return [
        (
            "",
            [
                pair.image1,
                text_cell(pair.image2),
                text_cell(kind_of(pair)),
                str(pair.raw),
                str(pair.kept),
                value_text(pair.confidence, 1),
                value_text(pair.ambiguity),
            ],
        )
        for pair in pairs
    ]


def pair_table(caption, pairs):
    """Return a table of pairs; empty where there are none."""
    from .markup import table

    head = ["image", "image", "found", "raw", "kept", "confidence", "ambiguity"]
    return table(caption, head, pair_rows(pairs)) if pairs else ""


def matrix_html(names, pairs):
    """Return the matrix of all pairs with its legend."""
    import numpy as np

    from . import matrix
    from .markup import render

    places = {name: place for place, name in enumerate(names)}
    first = np.array([places[pair.image1] for pair in pairs], int)
    second = np.array([places[pair.image2] for pair in pairs], int)
    kinds = np.array([matrix.KIND_NUMBERS.get(kind_of(pair), matrix.REJECTED) for pair in pairs], int)
    kept = np.array([pair.kept for pair in pairs], int)
    count = len(names)
    side = max(matrix.WIDTH, -(-count // matrix.cells(count)))
    step = max(1, -(-count // MOST_LABELS))
    hovered = ""
    if len(pairs) <= MOST_HOVERED:
        rows = [
            [low, high, int(kind), pair.raw, pair.kept, pair.confidence and round(pair.confidence, 1)]
            for low, high, kind, pair in zip(first.tolist(), second.tolist(), kinds, pairs)
        ]
        texts = {"names": names, "kinds": [name for name, _ in matrix.KINDS], "pairs": rows}
        hovered = json.dumps(texts, separators=(",", ":"), ensure_ascii=True).replace("<", "\\u003c")
    used = {matrix.NOT_TRIED} | set(kinds.tolist())
    return render(
        "matrix.html",
        url=matrix.data_url(matrix.picture(count, first, second, kinds, kept)),
        side=side,
        count=count,
        shared=matrix.cells(count),
        labels=[
            (name, (place + 0.5) * side / count) for place, name in enumerate(names) if place % step == 0
        ],
        every=step,
        kinds=[
            (name, "#%02x%02x%02x" % colour) for k, (name, colour) in enumerate(matrix.KINDS) if k in used
        ],
        scale=["#%02x%02x%02x" % tuple(int(v) for v in c) for c in (matrix.FEW, matrix.MANY)],
        most=int(kept.max(initial=0)),
        hovered=hovered,
    )


def counts_html(summary):
    """Return the tables of the numbers of pairs and of the run."""
    from .markup import joined, table

    asked, results, run = summary["pairs"], summary["results"], summary["run"]
    rows = [("", ["accepted", str(results["accepted"])])]
    rows += [("", ["\u2003" + name, str(n)]) for name, n in results["configs"].items()]
    rows += [("", ["rejected", str(results["rejected"])])]
    rows += [
        ("", ["\u2003" + ("too few inliers" if name == "ok" else name), str(n)])
        for name, n in results["rejected_by_status"].items()
    ]
    rows += [("", ["faulty", str(asked["faulty"])])]
    if asked["verified_by_other_programs"]:
        rows += [("", ["verified by other programs", str(asked["verified_by_other_programs"])])]
    times = [
        ("", ["verified by this run", str(asked["verified"])]),
        ("", ["verified before", str(asked["verified_before"])]),
        ("", ["threads", str(run["threads"])]),
        ("", ["time, s", value_text(run["seconds"], 1)]),
        ("", ["time of a pair, ms", value_text(run["ms_per_pair"])]),
        ("", ["processor time of a pair, ms", value_text(run["processor_ms_per_pair"])]),
        ("", ["memory at most, MiB", value_text(run["peak_memory_mib"], 0)]),
        ("", ["checksum of the rows", summary["checksum"] or "\u2013"]),
    ]
    return joined([table("Pairs", ["", "pairs"], rows), table("Run", ["", ""], times)])


def listed_html(title, texts, values):
    """Return the table of the numbers of tracks or cycles; empty where the run did not compute them."""
    from .markup import table

    if not values:
        return ""
    rows = [
        ("", [text, value_text(values[key], 2 if isinstance(values[key], float) else 0)])
        for key, text in texts
        if values.get(key) is not None
    ]
    return table(title, ["", ""], rows)


def images_html(names, pairs):
    """Return what connects the images, and a table of those with the fewest accepted pairs."""
    from .markup import joined, paragraph, table

    degree = Counter()
    for pair in pairs:
        if is_accepted(pair):
            degree.update((pair.image1, pair.image2))
    groups = connected_groups(names, pairs)
    large = [str(size) for size in groups if size > 1]
    alone = len(groups) - len(large)
    sentence = "Accepted pairs connect the images to %d group%s%s; %d image%s in no accepted pair." % (
        len(large),
        "" if len(large) == 1 else "s",
        " of %s images" % ", ".join(large[:10] + ["..."] * (len(large) > 10)) if large else "",
        alone,
        " is" if alone == 1 else "s are",
    )
    weakest = sorted(names, key=lambda name: (degree[name], natural(name)))[:ROWS]
    rows = [("", [name, str(degree[name])]) for name in weakest]
    return joined(
        [
            paragraph(sentence),
            table("Images with the fewest accepted pairs", ["image", "accepted pairs"], rows),
        ]
    )


def doubts_html(pairs, summary):
    """Return the tables of pairs that are worth a look."""
    from .markup import joined

    accepted = [pair for pair in pairs if is_accepted(pair)]
    known = [pair for pair in accepted if pair.confidence is not None]
    accused = {tuple(names) for names in (summary.get("cycles") or {}).get("accused_pairs", ())}
    against = [pair for pair in accepted if (pair.image1, pair.image2) in accused]
    ambiguous = [pair for pair in accepted if (pair.ambiguity or 0) >= AMBIGUOUS]
    return joined(
        [
            pair_table("Accepted pairs that triplets accuse (of %d)" % len(against), against[:ROWS]),
            pair_table(
                "Accepted pairs with the least confidence", sorted(known, key=lambda p: p.confidence)[:ROWS]
            ),
            pair_table(
                "Accepted pairs whose matches a second relation explains, too (of %d)" % len(ambiguous),
                sorted(ambiguous, key=lambda p: -p.ambiguity)[:ROWS],
            ),
        ]
    )


def faulty_html(pairs):
    """Return the table of the pairs whose rows cannot be used; empty where there are none."""
    from .markup import cut_rows, joined, table, text_cell

    faulty = [pair for pair in pairs if pair.status == "faulty"]
    if not faulty:
        return ""
    rows = [("", [p.image1, text_cell(p.image2), text_cell(p.message)]) for p in faulty]
    rows, rest = cut_rows(rows, "the CSV file of corrsel_verify --report")
    return joined(
        [table("Pairs that could not be verified", ["image", "image", "reason"], rows, css="texts"), rest]
    )


def build(pairs, summary):
    """Return the page as HTML."""
    from markupsafe import Markup

    from .markup import FOLDER, render

    mentioned = {name for pair in pairs for name in (pair.image1, pair.image2)}
    names = sorted(mentioned | set(summary["images"]), key=natural)
    sections = [
        ("Pairs", counts_html(summary)),
        ("Matrix of the pairs", matrix_html(names, pairs) if names else ""),
        ("Images", images_html(names, pairs) if names else ""),
        ("Tracks", listed_html("Tracks through the verified matches", TRACK_TEXTS, summary.get("tracks"))),
        ("Cycles", listed_html("Rotations around triplets of images", CYCLE_TEXTS, summary.get("cycles"))),
        ("Pairs to look at", doubts_html(pairs, summary)),
        ("Faulty pairs", faulty_html(pairs)),
    ]
    return render(
        "verification.html",
        summary=summary,
        style=Markup((FOLDER / "style.css").read_text(encoding="utf-8")),
        sections=[(title, body) for title, body in sections if body],
    )


def main(arguments=None):
    """Run the command line; return the exit status."""
    words = sys.argv[1:] if arguments is None else arguments
    if len(words) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    from .__main__ import write_atomically

    try:
        text = build(read_pairs(words[0]), read_summary(words[1]))
        write_atomically(Path(words[2]), text, "give another file to --report")
    except ReportError as error:
        print("%s: error: %s" % (PROGRAM, error), file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        if error.name not in ("jinja2", "markupsafe", "numpy"):
            raise
        print(
            "%s: error: needs the Python package %s: apt install python3-%s"
            % (PROGRAM, error.name, error.name),
            file=sys.stderr,
        )
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

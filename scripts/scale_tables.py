"""The tables of docs/scale.md, made of docs/data/scale.csv: what was measured, and what follows for more pairs."""

import csv
import math

VERIFICATION = "verification on one thread"
BEGINNING = "beginning of a part"
MERGE = "merge"
MEMORY = "memory, undivided"
DATABASE = "database with keypoints and matches"
ROWS = "rows that verification adds"
#: What the second table states: title, step, column, what is taken off, factor from the unit of the column, unit, digits.
QUANTITIES = (
    (VERIFICATION, "undivided", "processor_s", None, 1e6 / 3600, "processor hours", 2),
    (BEGINNING, "begin", "processor_s", None, 1e6, "processor s", 1),
    (MERGE, "merge", "processor_s", None, 1e6, "processor s", 1),
    (MEMORY, "undivided", "memory_mib", None, 1e6, "MiB", 0),
    (DATABASE, "undivided", "database_bytes", None, 1e6 / 1e9, "GB", 2),
    (ROWS, "undivided", "written_bytes", "database_bytes", 1e6 / 1e9, "GB", 2),
    ("files of all parts", "parts", "written_bytes", None, 1e6 / 1e9, "GB", 2),
)
SIZES = (10**6, 10**7, 10**8, 10**9)
SHARE = 10**6  # pairs of one database, where there are many
HOUR = 3600.0


def table(header, rows):
    """Return a Markdown table whose columns of numbers are aligned to the right."""
    lines = [header, ["---"] + ["--:"] * (len(header) - 1)] + rows
    return "".join("| %s |\n" % " | ".join(map(str, line)) for line in lines)


def read(path):
    """Return the rows of the file as {step: {pairs: row}}, and one of them."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = {}
    for row in rows:
        found.setdefault(row["step"], {})[int(row["pairs"])] = row
    return found, rows[0]


def values(steps, step, column, minus):
    """Return [(pairs, value)] of a quantity by ascending number of pairs."""
    return [
        (pairs, float(row[column]) - (float(row[minus]) if minus else 0))
        for pairs, row in sorted(steps[step].items())
    ]


def line(points):
    """Return growth a pair, constant part, and the largest deviation of a point in between from the line, as a share.

    The line goes through the points with the fewest and with the most pairs.
    """
    (n, first), (m, last) = points[0], points[-1]
    growth = (last - first) / (m - n)
    constant = first - growth * n
    deviation = max(
        [abs(value / (constant + growth * pairs) - 1) for pairs, value in points[1:-1]], default=0
    )
    return growth, constant, deviation


def measured_rows(steps):
    """Return the table of the measured points."""
    parts = next(iter(steps["parts"].values()))["parts"]
    header = ["pairs", "undivided, s", "ms a pair", "beginning of a part, s", parts + " parts, s", "merge, s"]
    header += ["memory, MiB", "database, MB", "rows, B a pair", "parts, B a pair"]
    body = []
    for pairs, row in sorted(steps["undivided"].items()):
        seconds, size = float(row["processor_s"]), int(row["database_bytes"])
        body.append(
            [
                "{:,}".format(pairs),
                "%.1f" % seconds,
                "%.2f" % (1000 * seconds / pairs),
                "%.2f" % float(steps["begin"][pairs]["processor_s"]),
                "%.1f" % float(steps["parts"][pairs]["processor_s"]),
                "%.2f" % float(steps["merge"][pairs]["processor_s"]),
                "%.1f" % float(row["memory_mib"]),
                "%.1f" % (size / 1e6),
                "%.0f" % ((int(row["written_bytes"]) - size) / pairs),
                "%.0f" % (int(steps["parts"][pairs]["written_bytes"]) / pairs),
            ]
        )
    return table(header, body)


def growth_rows(steps):
    """Return the table of the growth for each million pairs."""
    body = []
    for title, step, column, minus, factor, unit, digits in QUANTITIES:
        growth, _, deviation = line(values(steps, step, column, minus))
        body.append([title, "%.*f %s" % (digits, growth * factor, unit), "%.0f %%" % (100 * deviation)])
    return table(["for each million pairs", "growth", "deviation"], body)


def amount(number):
    """Return a number with two digits that count."""
    if number >= 100:
        return "{:,.0f}".format(round(number, 2 - len("%.0f" % number)))
    return "%.2g" % number


def at(steps, title, pairs):
    """Return the value of a quantity for a number of pairs, by its line, in the unit of its column."""
    step, column, minus = next(quantity[1:4] for quantity in QUANTITIES if quantity[0] == title)
    growth, constant, _ = line(values(steps, step, column, minus))
    return constant + growth * pairs


def undivided_rows(steps):
    """Return the table of what follows for more pairs in one database."""
    body = []
    for pairs in SIZES:
        numbers = (
            at(steps, VERIFICATION, pairs) / HOUR,
            at(steps, MERGE, pairs) / HOUR,
            at(steps, DATABASE, pairs) / 1e9,
            at(steps, ROWS, pairs) / 1e9,
            at(steps, MEMORY, pairs) / 1024,
        )
        body.append(["10^%d" % round(math.log10(pairs))] + [amount(number) for number in numbers])
    header = [
        "pairs in one database",
        "verification, processor h",
        "merge, processor h",
        "database, GB",
        "rows, GB",
    ]
    return table(header + ["memory undivided, GiB"], body)


def divided_rows(steps):
    """Return the table of what follows for parts that verify for an hour, in one database and in several."""
    body = []
    for pairs in SIZES:
        parts = math.ceil(at(steps, VERIFICATION, pairs) / HOUR)
        beginning = at(steps, BEGINNING, pairs)
        numbers = [parts, beginning / 60, parts * beginning / HOUR]
        # Each of the databases has the same number of parts.
        numbers.append(
            pairs
            / SHARE
            * math.ceil(at(steps, VERIFICATION, SHARE) / HOUR)
            * at(steps, BEGINNING, SHARE)
            / HOUR
        )
        body.append(["10^%d" % round(math.log10(pairs))] + [amount(number) for number in numbers])
    header = ["pairs", "parts of an hour", "beginning of one, min", "beginning of all, processor h"]
    return table(header + ["the same in databases of 10^6 pairs, processor h"], body)


def source(row):
    """Return a sentence on where, with what and how the numbers were measured."""
    return (
        "Measured on: %(machine)s, one thread, commit %(commit)s, "
        "by `scripts/maintenance/measure_scale.py BUILD/bin/corrsel_verify`. The pairs have %(matches)s matches, and "
        "a share of %(true_share)s of them has a model.\n" % row
    )


def scale_tables(package):
    """Return the measured tables of docs/scale.md by the names of their markers."""
    steps, row = read(package / "docs" / "data" / "scale.csv")
    return {
        "source": source(row),
        "points": measured_rows(steps),
        "growth": growth_rows(steps),
        "undivided": undivided_rows(steps),
        "divided": divided_rows(steps),
    }

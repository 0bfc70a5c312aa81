"""The tables of the documentation that hold measured numbers, made of the files in docs/data/.

docs/data/README.md describes these files, and which command writes them anew.
"""

import csv
import json
from collections import OrderedDict

from scale_tables import scale_tables

# Selectors of the README's table, in the paper's order.
SHOWN = ("nnsr", "ransac", "st", "gtm", "usac", "vfc", "gms", "lpm", "adalam", "auto", "keep_all")
# Rows of the tables in docs/results.md and docs/performance.md; docs/data/all_results.md has all.
MAIN = (
    "nnsr nnsr:lowe ransac ransac:h ransac:f ransac:lo_prosac st gtm usac usac:h usac:f usac:frames vfc vfc:guided "
    "gms lpm lpm:paper lpm:v2 lpm:guided acransac acransac:h acransac:f adalam laf significant planes auto keep_all"
).split()
# Rows of the README's table of choices: the scene, the model that is returned, the selector, its name in performance.csv.
CHOICES = (
    ("unknown or changing", "if there is one", "auto", "auto"),
    ("a plane, or a camera that only turns", "homography", "usac", "usac:h"),
    ("a rigid scene with depth", "fundamental matrix", "usac:f", "usac:f"),
    ("a plane with hardly any inlier", "homography", "usac:frames", "usac:frames"),
    ("depth, or several motions", "no", "adalam", "adalam"),
    ("the same in less time, where the image neither turns nor zooms much", "no", "laf", "laf"),
    ("several planes, and which match belongs to which", "a homography for each", "planes", "planes"),
    ("a smooth deformation", "no", "vfc:guided", "vfc:guided"),
    ("the same without descriptor distances", "no", "vfc", "vfc"),
    ("anything; only descriptor distances are compared", "no", "nnsr", "nnsr"),
)
CHOICE_SIZE = 5000  # matches


def table(header, rows):
    """Return a Markdown table."""
    lines = [header, ["---"] * len(header)] + rows
    return "".join("| %s |\n" % " | ".join(line) for line in lines)


def marked(values):
    """Return F values as text, the highest one in bold, and a dash for a missing one."""
    best = max((value for value in values if value is not None), default=None)
    return ["–" if value is None else ("**%.1f**" if value == best else "%.1f") % value for value in values]


def all_selectors(results, names):
    """Return the table of F of selectors on every dataset; the highest value of a column is bold."""
    header, before = ["F, %"], None
    for column in results["columns"]:
        short = {"sift+sift": "sift", "orb+orb": "orb", "hessian_affine+sift": "hess."}.get(
            column["features"]
        )
        name = "%s (%d)" % (column["dataset"], column["pairs"])
        same = column["dataset"] == before
        header.append(short if same else name if short is None else "%s: %s" % (name, short))
        before = column["dataset"]
    values = OrderedDict((name, row) for name, row in results["f_percent"].items() if name in names)
    columns = [marked(column) for column in zip(*values.values())]
    return table(header, [["`%s`" % name] + list(row) for name, row in zip(values, zip(*columns))])


def commands(results):
    """Return the commands of the run as a block."""
    return "```\n%s```\n" % "".join(line + "\n" for line in results["command"])


def chosen(results):
    """Return the README's table: four datasets by some selectors; the highest value of a row is bold."""
    rows = []
    for dataset, features in (
        ("VGG", "hessian_affine+sift"),
        ("VGG", "orb+orb"),
        ("SymBench", "hessian_affine+sift"),
        ("AdelaideRMF", "given matches"),
    ):
        for number, column in enumerate(results["columns"]):
            if (column["dataset"], column["features"]) == (dataset, features):
                title = "%s, %s (%d)" % (dataset, features, column["pairs"])
                rows.append([title] + marked([results["f_percent"][name][number] for name in SHOWN]))
    return table(["F, %"] + list(SHOWN), rows)


def milliseconds(text):
    """Return a time with two or three digits."""
    return "%.3g" % float(text) if float(text) < 1000 else "%.0f" % float(text)


def growth(rows, names):
    """Return the table of the time of selectors by the number of matches."""
    times, exponents = OrderedDict(), {}
    for row in rows:
        if row["comparison"].startswith("growth/") and row["selector"] in names:
            times.setdefault(row["selector"], {})[int(row["n"])] = milliseconds(row["ours_ms"])
            if row["exponent"]:
                exponents[row["selector"]] = "%.2f" % float(row["exponent"])
    sizes = sorted({size for measured in times.values() for size in measured})
    body = [
        ["`%s`" % name] + [measured.get(size, "-") for size in sizes] + [exponents.get(name, "-")]
        for name, measured in times.items()
    ]
    return table(["ms"] + ["N = %d" % size for size in sizes] + ["exponent"], body)


def choices(rows):
    """Return the README's table of which selector suits which scene, with the times of CHOICE_SIZE matches."""
    times = {
        row["selector"]: float(row["ours_ms"])
        for row in rows
        if row["comparison"].startswith("growth/") and int(row["n"]) == CHOICE_SIZE
    }
    body = [
        [scene, model, "%.2g ms" % times[measured], "`%s`" % selector]
        for scene, model, selector, measured in CHOICES
    ]
    return table(["your scene", "model returned", "time for %d matches" % CHOICE_SIZE, "selector"], body)


def source(rows):
    """Return a sentence on where and with what the times were measured."""
    row = rows[0]
    return (
        "Measured on: %(cpu)s, %(threads)s thread, %(compiler)s, %(build_type)s, OpenCV %(opencv)s, "
        "%(kernels)s kernels, commit %(corrsel_commit)s.\n" % row
    )


def calibration(rows):
    """Return the table of the share of right matches by probability, for all datasets together and for each."""
    shares = OrderedDict()
    for row in rows:
        shares.setdefault((row["low"], row["high"]), {})[row["dataset"]] = row
    names = [name for name in OrderedDict.fromkeys(row["dataset"] for row in rows) if name != "all"]
    body = [
        [
            "%s to %s" % interval,
            by_name["all"]["matches"],
            by_name["all"]["mean_probability"],
            "**%s**" % by_name["all"]["share_right"],
        ]
        + [by_name[name]["share_right"] or "-" for name in names]
        for interval, by_name in shares.items()
    ]
    return table(["probability", "matches", "mean", "right"] + names, body)


def live(rows):
    """Return the table of latencies of the live nodelets, and where they were measured."""
    header = ["images", "features, selector", "rate", "dropped", "p50", "p95", "max", "processor", "memory"]
    body = [
        [
            row["images"],
            "`%(features)s`, `%(selector)s`" % row,
            "%(rate_hz)s Hz" % row,
            "%(dropped)s of %(sent)s" % row,
            "%(p50_ms)s ms" % row,
            "%(p95_ms)s ms" % row,
            "%(max_ms)s ms" % row,
            "%.0f %% of a core" % float(row["processor_percent"]),
            "%.0f MiB" % float(row["memory_mib"]),
        ]
        for row in rows
    ]
    where = "Measured on %(machine)s for %(seconds)s s each, commit %(commit)s.\n" % rows[0]
    return table(header, body) + "\n" + where


def release(rows):
    """Return the table of the steps of a release."""
    if not rows:
        return "No step has run yet.\n"
    body = [
        ["`%s`" % row["step"], row["result"], "%.0f min" % (float(row["seconds"]) / 60), row["summary"]]
        + [row["commit"], row["date"]]
        for row in rows
    ]
    return table(["step", "result", "time", "what it printed", "commit", "date"], body)


def measured_tables(package):
    """Return the measured tables of every document: {document: {name of the marker: text}}."""
    results = json.loads((package / "docs/data/results.json").read_text(encoding="utf-8"))

    def rows_of(name):
        with (package / "docs/data" / name).open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    rows = rows_of("performance.csv")
    return {
        "README.md": {"choices": choices(rows), "results": chosen(results)},
        "docs/results.md": {"commands": commands(results), "main-selectors": all_selectors(results, MAIN)},
        "docs/data/all_results.md": {
            "all-selectors": all_selectors(results, results["f_percent"]),
            "all-growth": growth(rows, [row["selector"] for row in rows]),
        },
        "docs/live.md": {"live": live(rows_of("live.csv"))},
        "docs/platforms.md": {"release": release(rows_of("release.csv"))},
        "docs/scale.md": scale_tables(package),
        "docs/selectors.md": {"probability": calibration(rows_of("probability.csv"))},
        "docs/performance.md": {
            "machine": source(rows),
            "growth": growth(rows, MAIN),
        },
    }

"""Puts the sections together into one file."""
from collections import namedtuple

from . import definitions, environment, examples, failures, overview, results, timing
from .figures import FigureWriter, set_up_figures
from .markup import section
from .style import CSS
from .words import esc

Section = namedtuple("Section", "key title module")

# In the report's order. Each module has html(run, figures), which returns the section's body.
SECTIONS = (
    Section("overview", "What won where", overview),
    Section("results", "Results", results),
    Section("time", "Time against F, and F pair by pair", timing),
    Section("examples", "Example pairs", examples),
    Section("failures", "Failures and left-out pairs", failures),
    Section("definitions", "Definitions", definitions),
    Section("environment", "Environment, configuration, seeds", environment),
)


def build(run):
    """Return the whole report as HTML."""
    set_up_figures()
    figures = FigureWriter()
    parts = [(s.key, s.title, s.module.html(run, figures)) for s in SECTIONS]
    title = "Correspondence selection benchmark"
    toc = "".join(
        '<li><a href="#%s">%d %s</a></li>' % (key, i, esc(name)) for i, (key, name, _) in enumerate(parts, 1)
    )
    out = [
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        "<title>%s: %s</title>" % (title, esc(run.name)),
        "<style>%s</style>\n</head>\n<body>" % CSS,
        '<header><h1>%s</h1>\n<p class="run">Run <b>%s</b></p>' % (title, esc(run.name)),
        overview.state_html(run),
        overview.lead_html(run),
        overview.notes_html(run),
        '<nav aria-label="Contents"><ul class="toc">%s</ul></nav></header>\n<main>' % toc,
    ]
    out += [section(i, key, name, body) for i, (key, name, body) in enumerate(parts, 1)]
    out.append(
        "</main>\n<footer>Made by report.py of corrsel from the files of the run. Means: summary.csv; pairs:"
        " pairs.csv.</footer>"
    )
    out.append("</body>\n</html>\n")
    return "\n".join(part for part in out if part)

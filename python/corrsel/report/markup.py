"""Blocks of the page, which templates/blocks.html draws: tables, figures, articles. Texts are escaped there.

HTML is a Markup, whose operator % escapes what it puts in; a text of another type is shown as it is.
"""
from collections import namedtuple
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from .selectors import are_many, group_of_selector, is_baseline
from .words import data_kind, features_text, preselection_text

FOLDER = Path(__file__).resolve().parent
ENVIRONMENT = Environment(
    loader=FileSystemLoader([str(FOLDER / "templates"), str(FOLDER)]),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
BLOCKS = ENVIRONMENT.get_template("blocks.html").module
paragraph, bold, small, below = BLOCKS.paragraph, BLOCKS.bold, BLOCKS.small, BLOCKS.below
heading, findings, contents, panels = BLOCKS.heading, BLOCKS.findings, BLOCKS.contents, BLOCKS.panels
details = BLOCKS.details
lines, with_badge, with_details = BLOCKS.lines, BLOCKS.with_badge, BLOCKS.with_details

HEADING = "heading"  # class of a row that heads others
MAX_ROWS = 200  # longest table of failures or left-out pairs; the rest stays in the CSV file
HIGHEST, LOWEST = "\u25b2", "\u25bc"
DASH = "\u2013"  # of a cell without a value

Cell = namedtuple("Cell", "content css span value", defaults=("", 1, None))
Cell.__doc__ = "A cell with CSS classes, a number of columns that it spans, and a value to sort it by."


def render(template, **values):
    """Return a template of this package filled in, as HTML."""
    return Markup(ENVIRONMENT.get_template(template).render(**values))


def joined(blocks, between="\n"):
    """Return blocks, or texts, one after the other; empty ones are left out."""
    return Markup(between).join(block for block in blocks if block)


def table(caption, head, rows, css="", long=False):
    """Return a table in a container of its own that scrolls.

    Rows are (class, [cells]); the first cell becomes the row's header, the others are texts or Cells. A row of the
    class HEADING has one cell, which heads the rows below.
    """
    return BLOCKS.table(caption, head, rows, " ".join(filter(None, [css, "long" if long else ""])))


def article(title, *blocks, identifier=""):
    """Return the part of a section that is about one group; empty blocks are left out."""
    return BLOCKS.article(title, joined(blocks), identifier)


def with_headings(rows):
    """Return the rows of (selector, row), with the names of the groups above theirs if the selectors are many."""
    if not are_many(rows):
        return [row for _, row in rows]
    out, group = [], None
    for selector, row in rows:
        if group_of_selector(selector) != group and not is_baseline(selector):
            group = group_of_selector(selector)
            out.append((HEADING, [group]))
        out.append(row)
    return out


def transposed(head, rows):
    """Return the head and the cells of the rows of a table whose columns become rows; classes of rows are lost."""
    columns = [list(column) for column in zip(head, *(cells for _, cells in rows))]
    return columns[0], columns[1:]


def group_heading(group):
    """Return a group's name as the HTML of a heading."""
    details = "%s, %s" % (features_text(group.features), preselection_text(group.preselection))
    return with_details(dataset_html(group.dataset), details)


def text_cell(text):
    """Return the cell of a text, which is aligned to the left."""
    return Cell(text, "text")


def best_cell(text, rest="", of="row", mark=HIGHEST, title=None):
    """Return the cell of the best value of a row or column; `title` explains another mark."""
    return Cell(BLOCKS.marked_best(text, mark, title or "best of the " + of) + rest, "best")


def compared_cell(text, best, mark=HIGHEST):
    """Return the cell of a value as text, marked where it reads like the best one of its column."""
    return best_cell(text, of="column", mark=mark) if best is not None and text == best else text


def selector_name(selector):
    """Return the name of a selector for the first cell of its row, with a remark on the baseline."""
    return joined([selector, small("baseline") if is_baseline(selector) else ""], " ")


def row_class(selector):
    """Return the class of the row of a selector."""
    return "baseline" if is_baseline(selector) else ""


def breakable(name):
    """Return a name as HTML that may break after its underscores."""
    return Markup("_<wbr>").join(name.split("_"))


def dataset_html(dataset):
    """Return a dataset's name as HTML, with a badge where it is not real."""
    kind = data_kind(dataset)
    return dataset if kind == "real" else with_badge(dataset, kind)


def sources(run, *names):
    """Return a line of links to files of the run's folder, those that are there."""
    links = [(run.link + quote(name), name) for name in names if (run.folder / name).is_file()]
    return BLOCKS.files(links) if links else ""


def cut_rows(rows, source):
    """Return the rows that are shown, and a remark on the others."""
    rest = len(rows) - MAX_ROWS
    return rows[:MAX_ROWS], paragraph("%d more in %s." % (rest, source), "small") if rest > 0 else ""

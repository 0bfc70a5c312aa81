"""Building blocks of the page: tables, sections, paragraphs."""
import re
from urllib.parse import quote

from .selectors import are_many, group_of_selector, is_baseline
from .words import data_kind, esc, features_text, preselection_text

HEADING = "heading"  # class of a row that heads others
MAX_ROWS = 200  # longest table of failures or left-out pairs; the rest stays in the CSV file


def table(caption, head, rows, css="", long=False):
    """Return a table in a container of its own that scrolls; head cells and rows are HTML.

    Rows are (class, [cells]); the first cell becomes the row's header. Cells may be (attributes, HTML). A row of the
    class HEADING has one cell, which heads the rows below.
    """
    out = [
        '<div class="scroll" role="region" aria-label="%s" tabindex="0">'
        % esc(re.sub("<[^>]*>", "", caption))
    ]
    out.append(
        '<table class="%s"><caption>%s</caption>'
        % (" ".join(filter(None, [css, "long" if long else ""])), caption)
    )
    out.append(
        "<thead><tr>%s</tr></thead><tbody>" % "".join('<th scope="col">%s</th>' % cell for cell in head)
    )
    for row_css, cells in rows:
        if row_css == HEADING:
            cell = '<th scope="colgroup" colspan="%d">%s</th>' % (len(head), cells[0])
            out.append('<tr class="%s">%s</tr>' % (HEADING, cell))
            continue
        parts = ['<th scope="row">%s</th>' % cells[0]]
        for cell in cells[1:]:
            attributes, content = cell if isinstance(cell, tuple) else ("", cell)
            parts.append("<td%s>%s</td>" % (" " + attributes if attributes else "", content))
        out.append("<tr%s>%s</tr>" % (' class="%s"' % row_css if row_css else "", "".join(parts)))
    out.append("</tbody></table></div>")
    return "\n".join(out)


def with_headings(rows):
    """Return the rows of (selector, row), with the names of the groups above theirs if the selectors are many."""
    if not are_many(rows):
        return [row for _, row in rows]
    out, group = [], None
    for selector, row in rows:
        if group_of_selector(selector) != group and not is_baseline(selector):
            group = group_of_selector(selector)
            out.append((HEADING, [esc(group)]))
        out.append(row)
    return out


def transposed(head, rows):
    """Return the head and the cells of the rows of a table whose columns become rows; classes of rows are lost."""
    columns = [list(column) for column in zip(head, *(cells for _, cells in rows))]
    return columns[0], columns[1:]


def section(number_, identifier, title, body):
    """Return a numbered section."""
    return '<section id="%s"><h2><span class="no">%d</span> %s</h2>\n%s\n</section>' % (
        identifier,
        number_,
        esc(title),
        body,
    )


def paragraph(text, css=""):
    """Return a paragraph of HTML."""
    return "<p%s>%s</p>" % (' class="%s"' % css if css else "", text)


def group_heading(group):
    """Return a group's name as the HTML of a heading."""
    details = "%s, %s" % (features_text(group.features), preselection_text(group.preselection))
    return '%s <span class="sub">%s</span>' % (dataset_html(group.dataset), esc(details))


def best_cell(text, rest="", of="row"):
    """Return the cell of the best value of a row or column."""
    mark = '<span class="mark" title="best of the %s">\u25b2</span>' % of
    return ('class="best"', "<strong>%s</strong>%s%s" % (text, mark, rest))


def breakable(name):
    """Return a name as HTML that may break after its underscores."""
    return esc(name).replace("_", "_<wbr>")


def dataset_html(dataset):
    """Return a dataset's name as HTML, with a badge where it is not real."""
    kind = data_kind(dataset)
    return esc(dataset) + ("" if kind == "real" else ' <span class="kind">%s</span>' % esc(kind))


def sources(run, *names):
    """Return a line of links to files of the run's folder, those that are there."""
    links = [
        '<a href="%s%s">%s</a>' % (esc(run.link), quote(name), esc(name))
        for name in names
        if (run.folder / name).is_file()
    ]
    return '<p class="files">Files: %s</p>' % ", ".join(links) if links else ""


def cut_rows(rows, source):
    """Return the rows that are shown, and a remark on the others."""
    rest = len(rows) - MAX_ROWS
    return rows[:MAX_ROWS], paragraph("%d more in %s." % (rest, source), "small") if rest > 0 else ""

"""Building blocks of the page: tables, sections, paragraphs."""
import re
from urllib.parse import quote

from .words import data_kind, esc, features_text, preselection_text

MAX_ROWS = 200  # longest table of failures or left-out pairs; the rest stays in the CSV file


def table(caption, head, rows, css="", long=False):
    """Return a table in a container of its own that scrolls; head cells and rows are HTML.

    Rows are (class, [cells]); the first cell becomes the row's header. Cells may be (attributes, HTML).
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
        parts = ['<th scope="row">%s</th>' % cells[0]]
        for cell in cells[1:]:
            attributes, content = cell if isinstance(cell, tuple) else ("", cell)
            parts.append("<td%s>%s</td>" % (" " + attributes if attributes else "", content))
        out.append("<tr%s>%s</tr>" % (' class="%s"' % row_css if row_css else "", "".join(parts)))
    out.append("</tbody></table></div>")
    return "\n".join(out)


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

"""Drawing with matplotlib: settings, axes, labels, and the way of a figure into the page."""
import contextlib
import io
import re
import textwrap
import warnings

import matplotlib
import numpy as np
from markupsafe import Markup, escape

matplotlib.use("Agg")
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402  (the backend is chosen first)
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator  # noqa: E402

from .markup import BLOCKS, joined  # noqa: E402
from .selectors import DARK, YELLOW, parts  # noqa: E402

PNG_DPI = 150
FINEST = 400  # steps along an axis that a figure shows apart


def set_up_figures():
    """Make figures the same whatever the user's matplotlib settings are."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(
        {
            "svg.fonttype": "none",
            "svg.hashsalt": "corrsel",
            "font.family": "sans-serif",
            "font.sans-serif": ["DejaVu Sans"],
            "font.size": 9,
            "axes.labelsize": 9,
            "axes.titlesize": 10,
            "axes.titleweight": "bold",
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": "#8a8a8a",
            "axes.linewidth": 0.8,
            "axes.axisbelow": True,
            "axes.unicode_minus": False,
            "xtick.color": "#444444",
            "ytick.color": "#444444",
            "xtick.labelsize": 8.5,
            "ytick.labelsize": 8.5,
            "grid.color": "#e2e2e2",
            "grid.linewidth": 0.7,
            "lines.linewidth": 1.5,
            "lines.markersize": 4.5,
            "hatch.linewidth": 0.6,
        }
    )
    warnings.filterwarnings("ignore", message=".*[Gg]lyph.*missing.*")


def plot_text(text, longest=22):
    """Return a name for a figure: not too long, and never taken for a formula."""
    text = text if len(text) <= longest else text[: longest - 1] + "\u2026"
    return text.replace("$", r"\$")


def new_axes(width, height, left, right, bottom, top):
    """Return a figure and its axes; sizes and margins in inches."""
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    box = [left / width, bottom / height, (width - left - right) / width, (height - bottom - top) / height]
    return figure, figure.add_axes(box)


@contextlib.contextmanager
def marked(axes, selector):
    """What is drawn in this block belongs to a selector: the page's script switches it off with the selector."""
    before = set(axes.get_children())
    yield
    drawn = [artist for artist in axes.get_children() if artist not in before]
    mark(axes.figure, selector, drawn + [a.arrow_patch for a in drawn if getattr(a, "arrow_patch", None)])


def mark(figure, selector, artists):
    """Give artists of a selector identifiers; they are unique, because the figure's file has them too."""
    for artist in artists:
        figure.marks = getattr(figure, "marks", 0) + 1
        artist.set_gid("selector-%d:%s" % (figure.marks, selector))


def selector_ticks(axis, selectors, longest, **options):
    """Write the names of selectors along an axis, one at each tick; the options are those of texts."""
    axis.set_ticklabels([plot_text(selector, longest) for selector in selectors], **options)
    for label, selector in zip(axis.get_ticklabels(), selectors):
        mark(axis.axes.figure, selector, [label])


def name_rows(axes, names, pad=0.5):
    """Make one row for each name along the vertical axis, the first on top."""
    axes.set_yticks(range(len(names)))
    axes.set_yticklabels(names)
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(len(names) - pad, pad - 1)


def selector_rows(axes, selectors, longest, pad=0.5):
    """Make one row for each selector along the vertical axis; names are cut to `longest` characters."""
    name_rows(axes, selectors, pad)
    selector_ticks(axes.yaxis, selectors, longest)


def safe_name(*parts):
    """Return a file name without ending made of any texts: small letters, digits, '+', '-' and '_'."""
    text = re.sub("[^a-z0-9+-]+", "_", "_".join(str(part) for part in parts if part).lower())
    return text.strip("_")[:100] or "figure"


class FigureWriter:
    """Turns figures into inline SVG, each with its own identifiers, and on request into files."""

    def __init__(self, folder=None, link="figures/"):
        """Start counting figures; files go to the folder, `link` leads from the page to it. No folder, no files."""
        self.count = 0
        self.folder = folder
        self.link = link
        self.names = set()
        self.swatches = {}  # selector -> its swatch

    def __call__(self, figure, label, name=None, css="plot"):
        """Return a figure as an inline SVG element with an accessible label.

        With a name the figure is also written as NAME.png and NAME.svg, linked below it.
        The name may hold anything: it is made safe and unique. OSError if it cannot be written.
        """
        self.count += 1
        stream = io.StringIO()
        figure.savefig(stream, format="svg", transparent=True, metadata={"Date": None})
        text = stream.getvalue()
        files = self.write(figure, label, name) if name and self.folder else ""
        text = text[text.index("<svg") :]
        text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
        text = re.sub(r"<(metadata|style)\b.*?</\1>", "", text, flags=re.S)
        text = self.shorten(text)
        view_box = re.search(r'viewBox="([^"]*)"', text).group(1)
        opening = '<svg class="%s" role="img" aria-label="%s" viewBox="%s">' % (css, escape(label), view_box)
        return Markup(opening + text[text.index(">") + 1 :].strip()) + files

    def write(self, figure, label, name):
        """Write a figure's files with a legend and a caption; return the links to them.

        On the page legend and caption stand beside the figure, so only the files contain them.
        """
        base = safe_name(name)
        name, i = base, 1
        while name in self.names:
            i += 1
            name = "%s_%d" % (base, i)
        self.names.add(name)
        self.folder.mkdir(exist_ok=True)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        if labels:
            # Drawn last = on top = first in the report's order.
            figure.axes[0].legend(
                handles[::-1], labels[::-1], loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False
            )
        text = plot_text("\n".join(textwrap.wrap(label, 70)), longest=400)
        figure.text(0.01, 1.02, text, fontsize=8, color=DARK, va="bottom")
        for ending, options in (
            ("svg", {"metadata": {"Date": None}}),
            ("png", {"dpi": PNG_DPI, "metadata": {"Software": None}}),
        ):
            path = self.folder / ("%s.%s" % (name, ending))
            figure.savefig(path, facecolor="white", bbox_inches="tight", pad_inches=0.08, **options)
        return BLOCKS.figure_files(["%s%s.%s" % (self.link, name, kind) for kind in ("png", "svg")])

    def again(self, svg):
        """Return an inline SVG for another place of the page: with separate identifiers."""
        self.count += 1
        return Markup(re.sub(r'(id="|href="#|url\(#)f\d+-', lambda m: "%sf%d-" % (m[1], self.count), svg))

    def shorten(self, text):
        """Give the identifiers of one figure short names of its own and round its coordinates."""
        text = re.sub(r' id="selector-\d+:([^"]*)"', r' data-selector="\1"', text)
        names = {}
        for name in re.findall(r'\bid="([^"]+)"', text):
            names.setdefault(name, "f%d-%d" % (self.count, len(names)))
        used = set(re.findall(r'href="#([^"]+)"', text)) | set(re.findall(r"url\(#([^)]+)\)", text))
        text = re.sub(r' id="([^"]+)"', lambda m: ' id="%s"' % names[m[1]] if m[1] in used else "", text)
        text = re.sub(r'href="#([^"]+)"', lambda m: 'href="#%s"' % names.get(m[1], m[1]), text)
        text = re.sub(r"url\(#([^)]+)\)", lambda m: "url(#%s)" % names.get(m[1], m[1]), text)
        text = re.sub(
            r"<[^>]*>", lambda tag: re.sub(r"(?<=\d)(\.\d\d)\d+", lambda m: m[1].rstrip("0."), tag[0]), text
        )
        return re.sub(r"\n\s*", "\n", text)


def line_figures(run, figures, selectors, plots, css, caption):
    """Return figures of lines with their legends: one, or one for each part of many selectors.

    plots(part) returns the plots, with lines for part.names and, in grey, for part.others.
    """
    out = []
    for part in parts(selectors):
        legend = [(swatch(run, figures, s), s) for s in part.names]
        text = caption + (" Grey: the selectors of the other groups." if part.others else "")
        out.append(BLOCKS.lines_figure(part.title.capitalize(), legend, list(plots(part)), text, css))
    return joined(out)


def part_ending(part):
    """Return the end of the name of a figure that shows a part of the selectors."""
    return "_" + part.title if part.title else ""


def visible(x, y):
    """Return which points of a curve of many a figure shows apart from their neighbours."""
    if len(x) <= FINEST:
        return np.ones(len(x), bool)
    cells = [(FINEST * (v - v.min()) / max(np.ptp(v), 1e-12)).round() for v in (x, y)]
    moves = np.any(np.diff(cells) != 0, axis=0)
    return np.append(moves, True) | np.insert(moves, 0, True)


def edge_of(style):
    """Return the colour of a selector's thin lines and edges: yellow is too pale on white."""
    return DARK if style["colour"] == YELLOW else style["colour"]


def line_style(style):
    """Return the matplotlib options of a selector's line and markers."""
    colour = style["colour"]
    return {
        "color": colour,
        "marker": style["marker"],
        "linestyle": style["line"],
        "markerfacecolor": "white" if style["hollow"] else colour,
        "markeredgecolor": edge_of(style),
        "markeredgewidth": 1.0,
    }


def draw_line(axes, x, y, style, **options):
    """Draw a selector's line with markers; yellow, too pale on white, gets a dark rim."""
    if style["colour"] == YELLOW:
        axes.plot(x, y, color=DARK, linewidth=2.6, linestyle=style["line"])
    axes.plot(x, y, **line_style(style), **options)


def draw_part(axes, run, part, line_of, **options):
    """Draw the lines of a part of the selectors, those of the others in grey.

    line_of(selector, named) returns x and y, None where there is no line; where `named`, it may draw what belongs to the
    line. The options are those of the line.
    """
    for selector in part.others + part.names[::-1]:
        named = selector not in part.others
        with marked(axes, selector):
            line = line_of(selector, named)
            if line and named:
                draw_line(axes, *line, run.styles[selector], label=plot_text(selector), **options)
            elif line:
                axes.plot(*line, color="#dcdcdc", linewidth=1.0, zorder=0.5)


def swatch(run, figures, selector):
    """Return a selector's line and marker as a small picture for a legend."""
    if selector not in figures.swatches:
        figure, axes = new_axes(0.5, 0.2, 0, 0, 0, 0)
        draw_line(axes, [0, 1, 2], [0, 0, 0], run.styles[selector], markevery=[1])
        axes.set_xlim(0, 2)
        axes.set_ylim(-1, 1)
        axes.axis("off")
        text = figures(figure, "", css="swatch")
        figures.swatches[selector] = text.replace('role="img" aria-label=""', Markup('aria-hidden="true"'))
    return figures.again(figures.swatches[selector])


def pixel_boxes(axes, points, obstacles):
    """Return the boxes (x0, y0, x1, y1), in pixels, of markers and of obstacles (corner, corner)."""
    scale = axes.figure.dpi / 72.0
    boxes = [
        (x - 4 * scale, y - 4 * scale, x + 4 * scale, y + 4 * scale)
        for x, y in axes.transData.transform(points)
    ]
    for corners in obstacles:
        (x0, y0), (x1, y1) = axes.transData.transform(corners)
        boxes.append((x0 - scale, y0 - scale, x1 + scale, y1 + scale))
    return boxes


def place_labels(axes, points, selectors, obstacles, names=None):
    """Write the name of a selector beside each point, clear of labels, points and obstacles as far as there is room.

    `names` are shown in place of the selectors' own.
    """
    labels = names or selectors
    scale, frame = axes.figure.dpi / 72.0, axes.get_window_extent()
    centres = axes.transData.transform(points)
    boxes = pixel_boxes(axes, points, obstacles)
    for i in sorted(range(len(labels)), key=lambda k: -centres[k][1]):
        width, height = (5.3 * len(plot_text(labels[i])) + 2) * scale, 9.5 * scale
        best = None
        for rank, (dx, dy) in enumerate(label_offsets()):
            x = centres[i][0] + dx * scale - (width if dx < 0 else width / 2 if dx == 0 else 0)
            y = centres[i][1] + dy * scale - height / 2
            box = (x, y, x + width, y + height)
            inside = overlap_area(box, (frame.x0, frame.y0, frame.x1, frame.y1))
            covered = [overlap_area(box, other) for other in boxes]
            cost = 50 * (width * height - inside) + rank * scale
            cost += sum(40 * scale + area for area in covered if area > 0)
            if best is None or cost < best[0]:
                best = (cost, box, dx, dy)
        _, box, dx, dy = best
        boxes.append(box)
        arrow = (
            {"arrowstyle": "-", "color": "#999999", "linewidth": 0.6} if max(abs(dx), abs(dy)) > 14 else None
        )
        with marked(axes, selectors[i]):
            axes.annotate(
                plot_text(labels[i]),
                points[i],
                xytext=(dx, dy),
                textcoords="offset points",
                ha="right" if dx < 0 else "center" if dx == 0 else "left",
                va="center",
                fontsize=8.5,
                arrowprops=arrow,
            )


def label_offsets():
    """Return the places tried for a label, nearest first, in points from its point."""
    near = [(7, 0), (-7, 0), (6, 8), (6, -8), (-6, 8), (-6, -8), (0, 11), (0, -11)]
    far = [(dx, dy) for dy in (18, -18, 28, -28, 38, -38) for dx in (12, -12)]
    return near + far


def overlap_area(a, b):
    """Return the area two boxes (x0, y0, x1, y1) share."""
    return max(0, min(a[2], b[2]) - max(a[0], b[0])) * max(0, min(a[3], b[3]) - max(a[1], b[1]))


def format_time_axis(axes, low, high):
    """Put plain numbers on a logarithmic axis, with steps between the decades where the range is short."""
    subs = (1.0,) if high / low > 300 else (1.0, 3.0) if high / low > 30 else (1.0, 2.0, 5.0)
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=subs))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: "%g" % x))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_minor_formatter(NullFormatter())

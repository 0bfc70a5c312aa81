"""Example pairs: the drawn matches of every selector."""
import base64
from collections import OrderedDict

from .markup import paragraph
from .reading import group_of
from .selectors import selector_key
from .words import PHOTOGRAPHED, at_tau, esc, features_text, preselection_text


def image_data(run, name):
    """Return an image of the run as a data URI, None where it is missing, elsewhere or no picture."""
    root = run.folder.resolve()
    kinds = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png"}
    for path in (run.folder / "images" / name, run.folder / name):
        try:
            path = path.resolve()
            if root in path.parents and path.suffix.lower() in kinds and path.is_file():
                code = base64.b64encode(path.read_bytes()).decode("ascii")
                return "data:image/%s;base64,%s" % (kinds[path.suffix.lower()], code)
        except (OSError, ValueError):
            pass
    return None


def image_caption(row):
    """Return the caption of an example as text, made of its numbers."""
    selected, correct, wrong, missed = (row[k] for k in ("n_selected", "n_correct", "n_wrong", "n_missed"))
    if selected is None:
        return "no counts"
    text = "%d selected" % selected
    if correct is not None:
        share = " (%.1f %%)" % (100 * correct / selected) if selected else ""
        text += ": %d correct%s" % (correct, share)
    text += ", %d wrong" % wrong if wrong is not None else ""
    text += "; %d correct ones missed" % missed if missed is not None else ""
    return text


def example_html(run, row, index):
    """Return one example image with its caption; a click opens it large, without any script."""
    title = "%s on %s %s %s" % (row["selector"], row["dataset"], row["sequence"], row["pair"])
    caption = image_caption(row)
    data = image_data(run, row["file"])
    if data is None:
        picture = '<p class="missing">image %s is missing</p>' % esc(row["file"])
    else:
        alt = "Matches selected by %s, drawn between the two images: %s" % (title, caption)
        picture = '<a class="open" href="#ex-%d" title="Enlarge"><img src="%s" alt="%s"></a>' % (
            index,
            data,
            esc(alt),
        )
    close = '<a class="close" href="#cell-%d">Close</a>' % index if data else ""
    return (
        '<div class="cell" id="cell-%d"><figure id="ex-%d">%s<figcaption><b>%s</b>'
        " %s</figcaption>%s</figure></div>"
        % (
            index,
            index,
            picture,
            esc(row["selector"]),
            esc(caption),
            close,
        )
    )


LEGEND = (
    ("#009E73", "correct", "selected and within \u03c4 of the truth"),
    ("#D55E00", "wrong", "selected, but further than \u03c4 from the truth"),
    ("#0072B2", "missed", "correct, but not selected"),
    ("#F0E442", "truth unknown", "selected where there is no ground truth"),
)


def html(run, figures):
    """Return the body of the section."""
    if not run.images:
        return paragraph("The run drew no example pairs.")
    items = "".join(
        '<li><svg class="swatch" viewBox="0 0 36 14" aria-hidden="true"><path d="M2 7H34" stroke="#555"'
        ' stroke-width="6.4"/><path d="M2.7 7H33.3" stroke="%s" stroke-width="5"/></svg><span><b>%s</b>:'
        " %s</span></li>" % (colour, name, esc(meaning))
        for colour, name, meaning in LEGEND
    )
    out = [
        paragraph(
            "Each line joins a match in the left image to its partner in the right one. Click an image to"
            " enlarge it."
        )
    ]
    out.append('<ul class="legend colours">%s</ul>' % items)
    pairs = OrderedDict()
    for row in run.images:
        pairs.setdefault((group_of(row), row["sequence"], row["pair"]), []).append(row)
    index = 0
    for (group, sequence, pair), rows in pairs.items():
        tau = at_tau(rows[0]["tau_px"])
        if group.dataset == "sample":
            tau += ", photographed" if sequence in PHOTOGRAPHED else ", generated"
        sub = "%s, %s, %s" % (features_text(group.features), preselection_text(group.preselection), tau)
        name = " / ".join(OrderedDict.fromkeys(filter(None, [group.dataset, sequence, pair])))
        out.append('<h3>%s <span class="sub">%s</span></h3><div class="grid">' % (esc(name), esc(sub)))
        for row in sorted(rows, key=lambda r: selector_key(r["selector"])):
            index += 1
            out.append(example_html(run, row, index))
        out.append("</div>")
    return "\n".join(out)

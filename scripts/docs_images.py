#!/usr/bin/env python3
"""Make the pictures of README.md and docs/.

Usage: docs_images.py diagram
       docs_images.py plots RUN_FOLDER
       docs_images.py matches [SAMPLES]
       docs_images.py selection [SAMPLES]
Each command takes --output FOLDER (default: docs/images of this package).

diagram  live.svg: the nodelets and their topics.
plots    vgg_f.svg and vgg_time.svg: F against the tolerance and against the selection time, on VGG with
         hessian_affine+sift. RUN_FOLDER is any run that holds these rows, for example that of
         `rosrun corrsel benchmark --experiment overall --dataset vgg --data_root DATA --output_dir RUN_FOLDER`.
         Times come from the run, so the machine should do nothing else meanwhile.
matches  before_after.png: ORB matches of the photographs graf 1 and 3 before and after `usac`. SAMPLES is the
         folder that fetch_samples.sh has filled (default: ~/.cache/corrsel/sample). Prints the numbers that the
         picture shows. Needs the Python module of corrsel.
selection  selection.png: what corrsel_match draws of the same photographs.

The same input always gives the same files. Exit status: 0 written, 2 unusable input.
"""
import argparse
import csv
import os
import shutil
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from xml.sax.saxutils import escape

package = Path(__file__).resolve().parent.parent

DATASET, FEATURES = "vgg", "hessian_affine+sift"
TOLERANCE = 5  # px
EVERY = 20  # the picture shows one match of so many
GAP = 16  # px between the two photographs
PICTURE_DPI = 110
PICTURE_WIDTH = 1200  # px, of selection.png
MAXIMUM_COVERAGE, NO_DITHER = 1, 0  # of Pillow, whose names for them differ between versions
GREEN, VERMILLION = "#009E73", "#D55E00"  # Okabe and Ito: they stay apart for colour-blind eyes


class ImageError(Exception):
    """Input from which a picture cannot be made; the text names input, reason and remedy."""


# --- live.svg ----------------------------------------------------------------------------------------------------

HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 980 404" role="img" aria-label="%s"
  font-family="DejaVu Sans, Verdana, sans-serif" font-size="13" text-anchor="middle" fill="#1b1b1b">
<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">
  <path d="M0 0L8 4L0 8z" fill="#444444"/></marker></defs>
<rect width="980" height="404" fill="white"/>
"""


def box(left, top, width, title, lines, colour):
    """Return a box of an SVG with a bold title and lines of text below it."""
    height = 30 + 18 * len(lines)
    parts = [
        '<rect x="%d" y="%d" width="%d" height="%d" rx="6" fill="%s" stroke="#444444"/>'
        % (left, top, width, height, colour),
        '<text x="%d" y="%d" font-weight="bold">%s</text>' % (left + width / 2, top + 20, escape(title)),
    ]
    for i, line in enumerate(lines):
        parts.append('<text x="%d" y="%d">%s</text>' % (left + width / 2, top + 40 + 18 * i, escape(line)))
    return "\n".join(parts)


def arrow(points, dashed=False, tip=True):
    """Return a line of an SVG through points, with a tip at its end."""
    return '<path d="M%s" fill="none" stroke="#444444" stroke-width="1.4"%s%s/>' % (
        "L".join("%d %d" % point for point in points),
        ' stroke-dasharray="5 4"' if dashed else "",
        ' marker-end="url(#tip)"' if tip else "",
    )


def label(x, y, *lines):
    """Return lines of small text of an SVG, the last one with its baseline at y."""
    return "\n".join(
        '<text x="%d" y="%d" font-size="12" fill="#005a8d">%s</text>'
        % (x, y - 16 * (len(lines) - 1 - i), escape(line))
        for i, line in enumerate(lines)
    )


def write_diagram(folder):
    """Write live.svg; return its path."""
    nodelet, other, aside = "#e8f1f8", "#f5f5f5", "#eef7f3"
    parts = [
        HEAD
        % "Cameras, FeatureMatcher, Selector and odometry in a row; below them MatchViewer, Evaluator, Tracker and RigMonitor",
        '<rect x="252" y="12" width="468" height="380" rx="10" fill="none" stroke="#999999" stroke-dasharray="2 3"/>',
        '<text x="486" y="32" fill="#555555">nodelets in one process: no image is copied</text>',
        box(10, 56, 124, "camera(s)", ["one or two"], other),
        box(266, 56, 150, "FeatureMatcher", ["detects, describes,", "matches"], nodelet),
        box(560, 56, 146, "Selector", ["keeps the correct", "matches"], nodelet),
        box(834, 56, 136, "your odometry", ["SLAM, tracking..."], other),
        arrow([(134, 84), (264, 84)]),
        label(193, 76, "left/image", "right/image"),
        label(193, 102, "or image"),
        arrow([(416, 84), (558, 84)]),
        label(487, 76, "correspondences"),
        arrow([(706, 84), (832, 84)]),
        label(774, 76, "matches", "selection"),
        arrow([(487, 86), (487, 166)], dashed=True, tip=False),
        arrow([(633, 122), (633, 166), (380, 166), (380, 202)], dashed=True),
        arrow([(603, 166), (603, 202)], dashed=True),
        label(436, 200, "correspondences", "selection"),
        box(276, 206, 208, "MatchViewer", ["draws the images with", "matches: matches/image"], aside),
        box(500, 206, 206, "Evaluator", ["compares with ground_truth:", "score"], aside),
        arrow([(492, 166), (492, 286), (380, 286), (380, 302)], dashed=True),
        arrow([(492, 286), (603, 286), (603, 302)], dashed=True),
        box(276, 306, 208, "Tracker", ["gives points an identity that", "lasts over frames: tracks"], aside),
        box(500, 306, 206, "RigMonitor", ["reports when a stereo rig", "was bent: rig_state"], aside),
        "</svg>",
    ]
    path = folder / "live.svg"
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")
    ElementTree.parse(str(path))  # a picture that no program can read is not kept silently
    return [path]


# --- vgg_f.svg, vgg_time.svg -------------------------------------------------------------------------------------


def copy_rows(source, target):
    """Copy the rows of a run's table that the plots show: one dataset, one kind of features, no presets."""
    try:
        with open(source, newline="", encoding="utf-8") as stream:
            head = stream.readline()  # pairs.csv has a line with its format before the header
            if not head.startswith("#"):
                stream.seek(0)
                head = ""
            reader = csv.DictReader(stream)
            rows = [
                row
                for row in reader
                if (row["dataset"], row["features"], row["preselection"]) == (DATASET, FEATURES, "none")
                and ":" not in row["selector"]
            ]
    except (OSError, KeyError) as error:
        raise ImageError(
            "%s: cannot be read (%s). Remedy: give the folder of a complete run." % (source, error)
        )
    if not rows:
        raise ImageError(
            "%s: no rows of %s with %s. Remedy: run the benchmark with --experiment overall --dataset %s."
            % (source, DATASET, FEATURES, DATASET)
        )
    with open(target, "w", newline="", encoding="utf-8") as stream:
        stream.write(head)
        writer = csv.DictWriter(stream, reader.fieldnames, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def write_plots(run_folder, folder):
    """Write the plots of a run with the functions that draw the report; return their paths."""
    from corrsel.report.figures import FigureWriter, set_up_figures
    from corrsel.report.reading import ReportError, read_run
    from corrsel.report.results import curve_panel
    from corrsel.report.selectors import parts
    from corrsel.report.timing import time_panel

    set_up_figures()
    with tempfile.TemporaryDirectory() as work:
        work = Path(work)
        for table in ("pairs.csv", "summary.csv"):
            copy_rows(run_folder / table, work / table)
        try:
            run = read_run(work)
        except ReportError as error:
            raise ImageError(str(error))
        group = run.groups[0]
        writer = FigureWriter(work / "figures")
        part = parts(run.selectors_of(group))[0]  # of many selectors, the paper's; the others are grey
        curve_panel(run, writer, group, part, "F", "f_paper", "vgg_f")
        if not time_panel(run, writer, group):
            raise ImageError("%s: holds no times. Remedy: give the folder of a complete run." % run_folder)
        for made, name in (("vgg_f.svg", "vgg_f.svg"), ("time_vgg.svg", "vgg_time.svg")):
            shutil.copyfile(str(work / "figures" / made), str(folder / name))
    return [folder / "vgg_f.svg", folder / "vgg_time.svg"]


# --- before_after.png --------------------------------------------------------------------------------------------


def read_samples(samples):
    """Return the photographs graf 1 and 3, and the homography between them, from a folder of samples."""
    import cv2

    images = [cv2.imread(str(samples / name)) for name in ("graf1.png", "graf3.png")]
    storage = cv2.FileStorage(str(samples / "H1to3p.xml"), cv2.FILE_STORAGE_READ)
    homography = storage.getFirstTopLevelNode().mat() if storage.isOpened() else None
    if homography is None or any(image is None for image in images):
        raise ImageError(
            "%s: graf1.png, graf3.png or H1to3p.xml cannot be read. Remedy: run scripts/fetch_samples.sh."
            % samples
        )
    return images, homography


def draw_pair(axes, images, matches, shown, errors, title):
    """Draw two images side by side with lines between the matches shown, in the colour of their truth."""
    import cv2
    import numpy as np
    from matplotlib.collections import LineCollection

    height = max(image.shape[0] for image in images)
    offset = images[0].shape[1] + GAP
    canvas = np.full((height, offset + images[1].shape[1]), 255, np.uint8)
    for image, left in zip(images, (0, offset)):  # pale, so that the lines stand out
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        canvas[: image.shape[0], left : left + image.shape[1]] = 255 - (255 - grey) * 0.6
    axes.imshow(canvas, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    lines = np.stack([matches.left[shown], matches.right[shown] + (offset, 0)], axis=1)
    colours = [GREEN if error <= TOLERANCE else VERMILLION for error in errors[shown]]
    axes.add_collection(LineCollection(lines, colors=colours, linewidths=0.7))
    axes.set_title(title, loc="left")
    axes.axis("off")


def load_corrsel():
    """Return the Python package with its modules in C++."""
    try:
        import corrsel
        from corrsel import match  # noqa: F401
    except ImportError as error:
        raise ImageError("the Python module of corrsel: %s. Remedy: see docs/python.md." % error)
    return corrsel


def save_picture(image, path):
    """Write an image of Pillow with 256 colours, which takes a third of the bytes."""
    image.quantize(256, method=MAXIMUM_COVERAGE, dither=NO_DITHER).save(str(path), optimize=True)


def write_matches(samples, folder):
    """Draw the matches of a pair of photographs before and after a selector; return the paths written."""
    corrsel = load_corrsel()
    import numpy as np
    from corrsel.report.figures import FigureCanvasAgg, Figure, set_up_figures
    from PIL import Image

    images, homography = read_samples(samples)
    matches = corrsel.match(images[0], images[1], "orb+orb")
    selection = matches.select("usac")
    errors = np.asarray(corrsel.ground_truth_errors(matches, homography=homography))
    set_up_figures()
    figure = Figure(figsize=(8, 6.9))
    FigureCanvasAgg(figure)
    axes = figure.subplots(
        2, 1, gridspec_kw={"left": 0, "right": 1, "bottom": 0, "top": 0.965, "hspace": 0.07}
    )
    for part, mask, words in (
        (axes[0], np.ones(len(matches), bool), "%d matches of ORB features: %.0f %% correct"),
        (axes[1], np.asarray(selection.mask, bool), "%d of them kept by usac: %.0f %% correct"),
    ):
        title = words % (mask.sum(), 100 * np.mean(errors[mask] <= TOLERANCE))
        print(title)
        draw_pair(part, images, matches, np.flatnonzero(mask)[::EVERY], errors, title)
    path = folder / "before_after.png"
    figure.savefig(str(path), dpi=PICTURE_DPI, metadata={"Software": None})
    save_picture(Image.open(str(path)).convert("RGB"), path)
    return [path]


# --- selection.png -----------------------------------------------------------------------------------------------


def write_selection(samples, folder):
    """Draw what corrsel_match draws of a pair of photographs; return the paths written."""
    corrsel = load_corrsel()
    from PIL import Image

    images, _ = read_samples(samples)
    matches = corrsel.match(images[0], images[1], "sift+sift")
    picture = corrsel.draw(images[0], images[1], matches, matches.select("auto"), width=PICTURE_WIDTH)
    path = folder / "selection.png"
    save_picture(Image.fromarray(picture[:, :, ::-1].copy()), path)
    return [path]


def main(arguments=None):
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS
    )
    parser.add_argument("picture", choices=("diagram", "plots", "matches", "selection"))
    parser.add_argument("input", nargs="?", type=Path)
    parser.add_argument("--output", type=Path, default=package / "docs" / "images", metavar="FOLDER")
    options = parser.parse_args(arguments)
    if options.picture == "plots" and options.input is None:
        parser.error("plots needs the folder of a run")
    if options.picture == "diagram" and options.input is not None:
        parser.error("diagram takes no input")
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        if options.picture == "diagram":
            paths = write_diagram(options.output)
        elif options.picture == "plots":
            paths = write_plots(options.input, options.output)
        else:
            write = write_matches if options.picture == "matches" else write_selection
            paths = write(options.input or cache / "corrsel" / "sample", options.output)
    except (ImageError, OSError) as error:
        print("docs_images.py: error: %s" % error, file=sys.stderr)
        return 2
    for path in paths:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())

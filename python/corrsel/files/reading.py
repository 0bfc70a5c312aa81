"""Finds out of which form an input is, and reads its pairs."""
import dataclasses
import posixpath

from .colmap import read_database
from .csv_list import read_csv
from .hloc import read_hloc
from .npz import ENDINGS, read_npz
from .pairs import InputError, points
from .truth import read_pair_list, truth_in_folder

FORMS = "a folder of .npz or .csv files, one such file, an HDF5 file of hloc, or a database of COLMAP"
BEGINNINGS = ((b"SQLite format 3\0", "colmap"), (b"\x89HDF\r\n\x1a\n", "hloc"), (b"PK", "npz"))


@dataclasses.dataclass
class Request:
    """What is to be read."""

    source: object  # path of the matches
    features: object = None  # path of hloc's features
    pairs: object = None  # path of a list of pairs
    truth: object = None  # folder of ground truth
    scores: str = "confidence"  # one of pairs.SCORES


def read_pairs(request):
    """Yield the MatchedPairs of the input, each with a key of its own. Raises InputError."""
    listed = None if request.pairs is None else read_pair_list(request.pairs)
    if request.truth is not None and not request.truth.is_dir():
        raise InputError("%s is not a folder of ground truth" % request.truth)
    form = form_of(request.source)
    if form == "hloc":
        if request.features is None:
            raise InputError(
                "%s is an HDF5 file of matches: name the file of the keypoints by --features" % request.source
            )
        pairs = read_hloc(request.source, request.features, listed, request.scores)
    elif form == "colmap":
        pairs = read_database(request.source, listed)
    else:
        pairs = _read_files(request, form, listed)
    truths = {} if listed is None else {(left, right): truth for left, right, truth, _ in listed}
    seen = {}
    for pair in pairs:
        pair.key = pair.key or key_of(pair.left_name, pair.right_name)
        if pair.key in seen:
            raise InputError(
                "%s and %s have the same name '%s'; rename one of them"
                % (seen[pair.key], pair.source, pair.key)
            )
        seen[pair.key] = pair.source
        _add_truth(pair, truths.get((pair.left_name, pair.right_name)), request.truth)
        yield pair


def form_of(path):
    """Return "npz", "csv", "hloc" or "colmap"."""
    if path.is_dir():
        forms = [form for form in ("npz", "csv") if any(path.rglob("*." + form))]
        if len(forms) == 1:
            return forms[0]
        raise InputError(
            "%s holds %s; give %s"
            % (path, "both .npz and .csv files" if forms else "neither .npz nor .csv files", FORMS)
        )
    try:
        with open(str(path), "rb") as file:
            beginning = file.read(16)
    except OSError as error:
        raise InputError("%s cannot be read (%s); give %s" % (path, error.strerror, FORMS)) from error
    for bytes_, form in BEGINNINGS:
        if beginning.startswith(bytes_):
            return form
    for suffixes, form in (((".npz",), "npz"), ((".h5", ".hdf5"), "hloc"), ((".db", ".sqlite"), "colmap")):
        if path.suffix in suffixes:
            raise InputError(
                "%s does not begin like a file of its kind (%s): it is damaged or empty" % (path, form)
            )
    return "csv"


def key_of(left, right):
    """Return the name of a pair of image files: their common folder, and both names below it."""
    left, right = left.lstrip("/"), right.lstrip("/")
    folder = posixpath.commonpath([posixpath.dirname(left) or ".", posixpath.dirname(right) or "."])
    if folder in ("", "."):
        return "%s-%s" % (left.replace("/", ":"), right.replace("/", ":"))
    names = (posixpath.relpath(name, folder).replace("/", ":") for name in (left, right))
    return folder + "/" + "-".join(names)


def _read_files(request, form, listed):
    """Yield the pairs of NPZ or CSV files."""

    def read(path, key):
        if form == "npz":
            return read_npz(path, key, request.scores)
        pair = read_csv(path, key)
        points(pair.left, pair.source, "x_left, y_left")
        points(pair.right, pair.source, "x_right, y_right")
        return pair

    if listed is not None:
        if not request.source.is_dir():
            raise InputError("--pairs needs a folder of files, and %s is a file" % request.source)
        for left, right, _, place in listed:
            path = _file_of(request.source, left, right, form, place)
            pair = read(path, _key_of_file(path, request.source))
            pair.left_name, pair.right_name = left, right
            yield pair
    elif request.source.is_dir():
        for path in sorted(request.source.rglob("*." + form)):
            yield read(path, _key_of_file(path, request.source))
    else:
        yield read(request.source, _key_of_file(request.source, request.source.parent))


def _key_of_file(path, root):
    name = path.relative_to(root).with_suffix("").as_posix()
    if name.endswith("/matches"):  # FOLDER/matches.csv of a pair's folder
        return name[: -len("/matches")]
    for ending in ENDINGS:
        if name.endswith(ending) and len(posixpath.basename(name)) > len(ending):
            return name[: -len(ending)]
    return name


def _file_of(folder, left, right, form, place):
    """Return the file of two images: LEFT_RIGHT_matches.npz or LEFT_RIGHT.npz with the names without folder and
    extension, as SuperGlue's program writes it."""
    stems = [posixpath.splitext(posixpath.basename(name))[0] for name in (left, right)]
    names = ["_".join(stems) + ending + "." + form for ending in ENDINGS + ("",)]
    for name in names:
        if (folder / name).is_file():
            return folder / name
    raise InputError(
        "%s: neither %s is in %s; remove the line, or add the file" % (place, " nor ".join(names), folder)
    )


def _add_truth(pair, listed, folder):
    own = None if folder is None else truth_in_folder(folder, pair.key)
    for truth, place in ((listed, "the list of pairs"), (own, str(folder))):
        if truth is None:
            continue
        if pair.truth.kind != "none":
            raise InputError(
                "%s has ground truth already, and %s has one, too; keep one of them" % (pair.source, place)
            )
        pair.truth = truth

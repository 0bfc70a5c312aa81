"""Reads CSV files in blocks of rows: small tables into dictionaries, large ones into columns."""
import csv
import io
import itertools
import math
import operator
import re

import numpy as np

from .words import plural

TEXT_COLUMNS = set(
    "dataset sequence pair features preselection selector status scene seed truth stage error file threads remark"
    " model motion true_motion".split()
)
BLOCK = 1000  # rows that are converted at a time; as many stay in the processor's cache
NAMED_LINES = 10  # of those that cannot be read
LINE_BREAK = re.compile("\r\n|\r|\n")
CONTROL = b"\0\1\2\3\4\5\6\7\x08\x0b\x0c" + bytes(range(14, 32)) + b"\x7f"


class ReportError(Exception):
    """Input from which no report can be made; the message names the input, the reason and the remedy."""


class Cleaned(io.RawIOBase):
    """The bytes of a file with U+FFFD in place of control characters, some of which stop Python's csv module."""

    def __init__(self, stream):
        """Read from a binary stream, which this object closes."""
        super().__init__()
        self.stream = stream

    def readable(self):
        """Tell that this stream can be read."""
        return True

    def readinto(self, buffer):
        """Read a third of what the buffer holds, because one byte may become three."""
        block = self.stream.read(max(1, len(buffer) // 3))
        if len(block.translate(None, CONTROL)) != len(block):
            block = re.sub(b"[%s]" % re.escape(CONTROL), "\ufffd".encode("utf-8"), block)
        buffer[: len(block)] = block
        return len(block)

    def close(self):
        """Close the stream."""
        self.stream.close()
        super().close()


def open_text(path):
    """Open a file as text: undecodable and control characters are replaced, line ends are kept."""
    raw = Cleaned(path.open("rb"))
    buffered = io.BufferedReader(raw, buffer_size=1 << 20)
    return io.TextIOWrapper(buffered, encoding="utf-8-sig", errors="replace", newline="")


def read_text(path):
    """Return a file's text with undecodable and control characters replaced, line ends kept."""
    with open_text(path) as stream:
        return stream.read()


def short_name(path):
    """Return a file's name as seen from the run folder."""
    return "images/" + path.name if path.parent.name == "images" else path.name


def to_number(text):
    """Return the finite number in a cell, None for an empty or undefined one; else ValueError."""
    if not text.strip():
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def to_numbers(cells):
    """Return cells as an array, NaN where to_number gives None; else ValueError."""
    try:
        values = np.fromiter(map(float, cells), np.float64, len(cells))
    except ValueError:
        values = np.array([float(cell) if cell.strip() else np.nan for cell in cells])
    values[np.isinf(values)] = np.nan
    return values


def describe_header_difference(found, expected):
    """Return one sentence on where a header differs from the expected one."""
    for i, name in enumerate(expected):
        if i >= len(found):
            return "it ends before column %d ('%s')" % (i + 1, name)
        if found[i] != name:
            return "column %d is '%s' instead of '%s'" % (i + 1, found[i], name)
    return "it has %d columns too many, the first is '%s'" % (
        len(found) - len(expected),
        found[len(expected)],
    )


class Blocks:
    """The rows of a CSV file, in blocks: iterate over (list of places in the block, list of rows).

    A last line without line end and rows with a wrong number of cells are left out. The user of a block rejects the
    places of further rows that it cannot read. All of them are noted when the iteration ends.
    """

    def __init__(self, path, header, notes, skipped=0):
        """Remember the file, the header that it must have, the list that receives the notes, and the lines before the header."""
        self.path, self.header, self.notes, self.skipped = path, header, notes, skipped
        self.block, self.lines_before, self.rejected = [], 0, []
        self.count, self.named = 0, []  # rejected rows of the blocks before, and the lines of the first ones

    def reject(self, place):
        """Count the row at a place of the block as one that cannot be read."""
        self.rejected.append(place)

    def end_block(self):
        """Find the lines of the block's rejected rows, as many as are named."""
        self.count += len(self.rejected)
        for place in sorted(self.rejected)[: NAMED_LINES - len(self.named)]:
            breaks = sum(len(LINE_BREAK.findall(cell)) for cells in self.block[: place + 1] for cell in cells)
            self.named.append(self.lines_before + place + 1 + breaks)
        self.rejected = []

    def whole_lines(self, stream):
        """Yield the lines of a stream but for a last one that is cut off."""
        yield stream.readline()
        for line in stream:
            if line[-1] not in "\r\n":
                self.notes.append(
                    "%s: the last line is cut off and was left out (the run was interrupted)."
                    % short_name(self.path)
                )
                return
            yield line

    def check_header(self, found):
        """Raise ReportError when the header is not the expected one."""
        if found != self.header:
            raise ReportError(
                "%s: wrong header: %s. Found '%s', expected '%s'. Remedy: write the folder again with the"
                " benchmark of this package version."
                % (
                    self.path,
                    describe_header_difference(found, self.header),
                    ",".join(found),
                    ",".join(self.header),
                )
            )

    def __iter__(self):
        """Yield (places, rows) of at most BLOCK rows each."""
        with open_text(self.path) as stream:
            if not any(line.strip() for line in stream):
                self.notes.append("%s is an empty file." % short_name(self.path))
                return
        with open_text(self.path) as stream:
            reader = csv.reader(self.whole_lines(stream))
            for _ in range(self.skipped):
                next(reader)
            self.check_header(next(reader, []))
            self.lines_before = reader.line_num
            for rows in iter(lambda: list(itertools.islice(reader, BLOCK)), []):
                self.block, places = rows, range(len(rows))
                if set(map(len, rows)) != {len(self.header)}:
                    for place, cells in enumerate(rows):
                        if cells and len(cells) != len(self.header):
                            self.reject(place)
                    places = [place for place in places if len(rows[place]) == len(self.header)]
                    rows = [rows[place] for place in places]
                if rows:
                    yield places, rows
                self.end_block()
                self.lines_before = reader.line_num
        if self.count:
            lines = ", ".join(map(str, self.named)) + (", ..." if self.count > len(self.named) else "")
            self.notes.append(
                "%s: %s could not be read and left out: line %s."
                % (short_name(self.path), plural(self.count, "line"), lines)
            )


def read_table(path, header, notes):
    """Read a CSV file into a dictionary per row, numbers as floats or None.

    A last line without line end and unreadable lines are left out and noted.
    Raises ReportError when the header is not the expected one.
    """
    blocks, out = Blocks(path, header, notes), []
    for places, rows in blocks:
        for place, cells in zip(places, rows):
            try:
                out.append({k: c if k in TEXT_COLUMNS else to_number(c) for k, c in zip(header, cells)})
            except ValueError:
                blocks.reject(place)
    return out


class Codes(dict):
    """Text -> its number, by first appearance."""

    def __missing__(self, text):
        """Give a new text the next number."""
        self[text] = len(self)
        return self[text]


class Columns:
    """A table as columns, for files of millions of rows: a row of pairs.csv takes 170 bytes of memory.

    columns[name] is a float array with NaN for empty cells, or, for a column of texts, an int32 array of codes.
    columns.texts[name] is the list of the texts that the codes stand for, by first appearance.
    """

    def __init__(self, header):
        """Hold no rows of a table with this header."""
        self.arrays = {name: np.empty(0, np.int32 if name in TEXT_COLUMNS else float) for name in header}
        self.texts = {name: [] for name in header if name in TEXT_COLUMNS}

    def __len__(self):
        """Return the number of rows."""
        return len(next(iter(self.arrays.values())))

    def __getitem__(self, name):
        """Return the array of a column."""
        return self.arrays[name]

    def resize(self, count):
        """Change the number of rows; what is added at the end is undefined until it is written."""
        for array in self.arrays.values():
            array.resize(count, refcheck=False)

    def reorder(self, order):
        """Put the rows into another order: an array of row numbers."""
        for name in self.arrays:
            self.arrays[name] = self.arrays[name][order]

    def code(self, name, text):
        """Return the code of a text; -1, which no row has, where it does not occur."""
        return self.texts[name].index(text) if text in self.texts[name] else -1

    def row(self, i):
        """Return one row as read_table does."""
        out = {}
        for name, array in self.arrays.items():
            if name in self.texts:
                out[name] = self.texts[name][array[i]]
            else:
                out[name] = None if np.isnan(array[i]) else float(array[i])
        return out

    def numbering(self, *names):
        """Return (number of each row's combination of texts, by first appearance; first row of each)."""
        combined = np.zeros(len(self), np.int64)
        for name in names:
            combined = combined * max(1, len(self.texts[name])) + self.arrays[name]
        _, first, inverse = np.unique(combined, return_index=True, return_inverse=True)
        by_appearance = np.argsort(first)
        ranks = np.empty(len(first), np.int32)
        ranks[by_appearance] = np.arange(len(first), dtype=np.int32)
        return ranks[inverse], first[by_appearance]


def converted(header, rows, codes):
    """Return the arrays of the columns of rows of cells; else ValueError."""
    cells = dict(zip(header, zip(*rows)))
    arrays = {name: to_numbers(cells[name]) for name in header if name not in codes}
    for name in codes:
        arrays[name] = np.fromiter(map(codes[name].__getitem__, cells[name]), np.int32, len(rows))
    return arrays


def is_readable(header, cells):
    """Tell whether all numbers of a row can be read."""
    try:
        for name, cell in zip(header, cells):
            if name not in TEXT_COLUMNS:
                to_number(cell)
    except ValueError:
        return False
    return True


def read_columns(path, header, notes, skipped=0):
    """Read a CSV file, with `skipped` lines before its header, into Columns; for what cannot be read, see read_table."""
    blocks, out, count = Blocks(path, header, notes, skipped), Columns(header), 0
    codes = {name: Codes() for name in out.texts}
    for places, rows in blocks:
        try:
            arrays = converted(header, rows, codes)
        except ValueError:
            good = [is_readable(header, cells) for cells in rows]
            for place in itertools.compress(places, map(operator.not_, good)):
                blocks.reject(place)
            rows = list(itertools.compress(rows, good))
            if not rows:
                continue
            arrays = converted(header, rows, codes)
        if count + len(rows) > len(out):
            out.resize((count + len(rows)) * 5 // 4)
        for name, array in arrays.items():
            out.arrays[name][count : count + len(rows)] = array
        count += len(rows)
    out.resize(count)
    out.texts = {name: list(codes[name]) for name in codes}
    return out


def read_optional(read, path, header, notes, consequence):
    """Return what a function reads from a file; None, which is noted with its consequence, where it is unusable."""
    if not path.is_file():
        notes.append("%s is missing: %s." % (short_name(path), consequence))
        return None
    try:
        return read(path, header, notes)
    except (ReportError, OSError, csv.Error) as error:
        notes.append("%s was not used (%s): %s." % (short_name(path), str(error).rstrip("."), consequence))
        return None


def read_optional_table(path, header, notes, consequence):
    """As read_table, but an absent or unusable file is noted, with its consequence, and gives no rows."""
    return read_optional(read_table, path, header, notes, consequence) or []


def read_optional_columns(path, header, notes, consequence):
    """As read_columns, but an absent or unusable file is noted, with its consequence, and gives no rows."""
    return read_optional(read_columns, path, header, notes, consequence) or Columns(header)

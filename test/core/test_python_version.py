"""The Python code runs with Python 3.8, the one of Ubuntu 20.04: its syntax, and the API that came later."""

import ast
import pathlib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: Modules, functions, methods and classes, by the version of Python that brought them. Names that occur elsewhere, too,
#: stand with their module.
LATER_NAMES = {
    "3.9": "zoneinfo graphlib removeprefix removesuffix is_relative_to with_stem readlink randbytes math.lcm "
    "math.nextafter math.ulp ast.unparse BooleanOptionalAction asyncio.to_thread ElementTree.indent functools.cache",
    "3.10": "itertools.pairwise bit_count hardlink_to EncodingWarning aiter anext",
    "3.11": "tomllib StrEnum enterContext ExceptionGroup datetime.UTC math.cbrt math.exp2 contextlib.chdir",
    "3.12": "itertools.batched math.sumprod typing.override",
}
#: Keyword arguments by function, and their version.
LATER_ARGUMENTS = {
    ("write_text", "newline"): "3.10",
    ("zip", "strict"): "3.10",
    ("glob", "root_dir"): "3.10",
    ("TemporaryDirectory", "ignore_cleanup_errors"): "3.10",
    ("basicConfig", "encoding"): "3.9",
    ("bisect", "key"): "3.10",
    ("bisect_left", "key"): "3.10",
    ("bisect_right", "key"): "3.10",
    ("sample", "counts"): "3.9",
    ("run", "process_group"): "3.11",
}
#: Built-in classes that are generic since 3.9: list[int].
GENERIC = ("dict", "frozenset", "list", "set", "tuple", "type")


def last_part(name):
    """The last part of a name."""
    return name.attr if isinstance(name, ast.Attribute) else getattr(name, "id", "")


def annotations(tree):
    """All annotations of a module."""
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if getattr(node, field, None) is not None:
                yield getattr(node, field)


def later_features(text, name="text"):
    """What of a module Python 3.8 does not have, as a list of messages."""
    try:
        tree = ast.parse(text, name, feature_version=(3, 8))
    except SyntaxError as error:
        return ["line %s: %s" % (error.lineno, error.msg)]
    found = []
    versions = {word: version for version, words in LATER_NAMES.items() for word in words.split()}
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Attribute):
            names = [node.attr, last_part(node.value) + "." + node.attr]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module] + ["%s.%s" % (node.module, alias.name) for alias in node.names]
        found += [
            "line %d: %s came with Python %s" % (node.lineno, used, versions[used])
            for used in names
            if used in versions
        ]
        if isinstance(node, ast.Call):
            for keyword in node.keywords:
                version = LATER_ARGUMENTS.get((last_part(node.func), keyword.arg))
                if version:
                    found.append(
                        "line %d: %s(%s=) came with Python %s"
                        % (node.lineno, last_part(node.func), keyword.arg, version)
                    )
        if isinstance(node, ast.Subscript) and getattr(node.value, "id", "") in GENERIC:
            found.append("line %d: %s[] came with Python 3.9" % (node.lineno, node.value.id))
    for annotation in annotations(tree):
        if any(
            isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr) for node in ast.walk(annotation)
        ):
            found.append("line %d: X | Y as a type came with Python 3.10" % annotation.lineno)
    return found


class PythonVersion(unittest.TestCase):
    """Python 3.8."""

    def test_no_file_needs_a_later_version(self):
        files = [path for suffix in ("py", "cfg") for path in ROOT.rglob("*." + suffix)]
        self.assertGreater(len(files), 50)
        for path in files:
            with self.subTest(file=str(path.relative_to(ROOT))):
                self.assertEqual(later_features(path.read_text(encoding="utf-8"), str(path)), [])

    def test_later_features_are_found(self):
        for text in (
            "match x:\n    case 1:\n        pass",
            "import tomllib",
            "from itertools import pairwise",
            "'a'.removeprefix('b')",
            "path.write_text('', newline='')",
            "zip(a, b, strict=True)",
            "def f(x: int | None): pass",
            "def f() -> list[int]: pass",
        ):
            with self.subTest(text=text):
                self.assertEqual(len(later_features(text)), 1)

    def test_python_3_8_passes(self):
        text = "import os\nos.chdir(f'{x=}')\nnumpy.nextafter(0, 1)\nif (n := f(a | b)):\n    zip(a, n[0])"
        self.assertEqual(later_features(text), [])


if __name__ == "__main__":
    unittest.main()

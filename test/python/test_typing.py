#!/usr/bin/env python3
"""The types of the package: the stubs state what the modules have, and mypy accepts the examples."""

import ast
import importlib
import importlib.util
import inspect
import pathlib
import shutil
import tempfile
import textwrap
import unittest

import corrsel
import installed

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "python" / "corrsel"
#: Modules with public names: the homes of the package's own names, which are private, and those that programs import.
HOMES = corrsel._HOMES  # pylint: disable=protected-access
MODULES = sorted(
    {home for home, _ in HOMES} - {"_core"}
    | {path.stem for path in PACKAGE.glob("[a-z]*.py") if "\n__all__ = " in path.read_text("utf-8")}
)
#: Python calls them by itself, and no program names them.
SELF = ast.dump(ast.parse("self").body[0].value)
IMPLIED = {"__delattr__", "__eq__", "__reduce__", "__repr__", "__setattr__"}


def stub_of(module):
    """Return the definitions of a stub by name: the syntax tree of classes, functions and variables."""
    tree = ast.parse((PACKAGE / (module + ".pyi")).read_text("utf-8"))
    return definitions(tree.body)


def definitions(body):
    """Return what a module or a class of a stub defines, by name."""
    found = {}
    for node in body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            found[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            found[node.target.id] = node
    return found


def parameters_of_stub(node):
    """Return (name, kind, whether it has a default) of every parameter of a function of a stub."""
    arguments, kind = node.args, inspect.Parameter
    plain = [(argument, kind.POSITIONAL_OR_KEYWORD) for argument in arguments.args]
    without = len(plain) - len(arguments.defaults)
    found = [(argument.arg, which, k >= without) for k, (argument, which) in enumerate(plain)]
    if arguments.vararg:
        found.append((arguments.vararg.arg, kind.VAR_POSITIONAL, False))
    for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults):
        found.append((argument.arg, kind.KEYWORD_ONLY, default is not None))
    if arguments.kwarg:
        found.append((arguments.kwarg.arg, kind.VAR_KEYWORD, False))
    return found


def parameters_of(function):
    """Return the same of a function."""
    return [
        (parameter.name, parameter.kind, parameter.default is not parameter.empty)
        for parameter in inspect.signature(function).parameters.values()
    ]


def members_of(cls):
    """Return the names of what a class defines itself: attributes, properties and methods of its users."""
    names = set(cls.__dict__) - IMPLIED
    if "__init__" in names:
        tree = ast.parse(textwrap.dedent(inspect.getsource(cls.__init__)))
        stored = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute))
        names |= {
            node.attr for node in stored if isinstance(node.ctx, ast.Store) and ast.dump(node.value) == SELF
        }
    return {
        name for name in names if not name.startswith("_") or name in {"__getitem__", "__init__", "__len__"}
    }


class Stubs(unittest.TestCase):
    """The files *.pyi beside the modules."""

    def test_public_names(self):
        text = (PACKAGE / "__init__.pyi").read_text("utf-8")
        imported = {}
        for node in ast.parse(text).body:
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    self.assertEqual(alias.name, alias.asname)  # mypy takes other imports for private ones
                    imported[alias.name] = node.module
        homes = {name: home for (home, _), names in HOMES.items() for name in names if home != "_core"}
        self.assertEqual(imported, homes)
        self.assertIn("\n__version__: str\n", text)

    def test_modules(self):
        for module in MODULES:
            stub = stub_of(module)
            public = {name for name in stub if not name.startswith("_")}
            expected = {name for (home, _), names in HOMES.items() if home == module for name in names}
            if not expected:
                expected = set(importlib.import_module("corrsel." + module).__all__)
                self.assertEqual(public, expected, module)
            self.assertEqual(expected - public, set(), module)

    def test_functions(self):
        checked = 0
        for module, name, node in self.definitions_of_modules():
            if isinstance(node, ast.FunctionDef):
                function = getattr(module, name)
                self.assertEqual(parameters_of_stub(node), parameters_of(function), name)
                checked += 1
        self.assertGreater(checked, 25)

    def test_classes(self):
        checked = 0
        for module, name, node in self.definitions_of_modules():
            if not isinstance(node, ast.ClassDef):
                continue
            cls, members = getattr(module, name), definitions(node.body)
            if issubclass(cls, tuple):
                self.assertEqual(tuple(members), cls._fields, name)
                continue
            self.assertEqual(set(members) - {"__hash__"}, members_of(cls), name)
            for member, definition in members.items():
                if isinstance(definition, ast.FunctionDef) and not hasattr(object, member):
                    self.check_method(cls, definition)
                    checked += 1
        self.assertGreater(checked, 12)

    def check_method(self, cls, definition):
        """Compare a method with its definition in the stub."""
        kinds = {decorator.id for decorator in definition.decorator_list}
        member = inspect.getattr_static(cls, definition.name)
        self.assertEqual("property" in kinds, isinstance(member, property), definition.name)
        self.assertEqual("classmethod" in kinds, isinstance(member, classmethod), definition.name)
        if isinstance(member, property):
            return
        function = member.__func__ if isinstance(member, classmethod) else member
        stub = [(name, kind) for name, kind, _ in parameters_of_stub(definition)]
        self.assertEqual(stub, [(name, kind) for name, kind, _ in parameters_of(function)], definition.name)

    def definitions_of_modules(self):
        """Yield the module, the name and the definition of everything in the stubs."""
        not_built = {
            home for home, built in HOMES if importlib.util.find_spec("corrsel." + built) is None
        }  # parts of the package that the options of the build leave out
        for module in MODULES:
            if module in not_built:
                continue
            for name, node in stub_of(module).items():
                found = importlib.import_module("corrsel." + module)
                self.assertTrue(hasattr(found, name) or name.startswith("_"), name)
                yield found, name, node


class Mypy(unittest.TestCase):
    """mypy --strict, as programs of users would be checked."""

    @classmethod
    def setUpClass(cls):
        if not shutil.which("mypy"):
            raise unittest.SkipTest("mypy is missing: install the package mypy")
        try:
            importlib.import_module("numpy.typing").NDArray  # pylint: disable=expression-not-assigned
        except (AttributeError, ImportError) as error:
            raise unittest.SkipTest("%s: numpy 1.21 has the types that are needed" % error) from error

    def mypy(self, *files):
        """Return what mypy finds in files. OpenCV's Python module has no types."""
        with tempfile.TemporaryDirectory() as folder:
            settings = pathlib.Path(folder) / "mypy.ini"
            settings.write_text("[mypy]\n[mypy-cv2.*]\nignore_missing_imports = True\n")
            # A program that was written for the package lies elsewhere than the package.
            copies = [shutil.copy(file, folder) for file in files]
            command = ["mypy", "--strict", "--config-file", settings, "--cache-dir", folder]
            return installed.run([*command, *copies], MYPYPATH=str(ROOT / "python"))

    def test_examples(self):
        examples = sorted((ROOT / "examples").glob("[0-9]*.py"))
        self.assertGreater(len(examples), 1)
        code, text = self.mypy(*examples)
        self.assertEqual(code, 0, text)

    def test_what_is_wrong_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "wrong.py"
            program.write_text(
                "import corrsel\n"
                "corrsel.Camera('pinhole', [[400, 0, 319.5], [0, 400, 239.5], [0, 0, 1]], size=(640, 480))\n"
                "corrsel.select([(1, 2.5)], [(3, 4)], 'auto', threshold=3, left_sise=(640, 480))\n"
                "corrsel.relative_pose([(1, 2)], [(3, 4)], 'pinhole', 'pinhole')\n"
                "corrsel.selekt\n"
            )
            code, text = self.mypy(program)
        self.assertEqual(code, 1, text)
        lines = [line.split(":")[1] for line in text.splitlines() if ": error: " in line]
        self.assertEqual(sorted(set(lines)), ["3", "4", "5"], text)


if __name__ == "__main__":
    unittest.main()

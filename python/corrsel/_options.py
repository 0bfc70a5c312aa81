"""Options: their list for people, and their values as the text that C++ reads and checks."""

import collections
import keyword

import numpy as np

from . import _core

#: One option: `name`; `value` in force, `range`, `unit` ("-" for a plain number) and `description` as text.
Option = collections.namedtuple("Option", "name value range unit description")


def options(name):
    """Return the options of a selector, of a feature algorithm or of the matching: a list of Option.

    name    a selector, optionally with a preset, e.g. "gms" or "lpm:v2": the values are those of the preset;
            a detector or descriptor, e.g. "orb"; or "match", the options of match() and match_features()

    Raises ValueError for an unknown name, listing the valid ones.
    """
    algorithms = _feature_options()
    if name in algorithms:
        return algorithms[name]
    try:
        return [Option(*row) for row in _core.Selector(name, {}).options()]
    except ValueError as error:
        if not algorithms:
            raise
        raise ValueError("%s; of features: %s" % (error, ", ".join(algorithms))) from None


def to_text(context, values):
    """Return keyword arguments as a dictionary of texts.

    A trailing underscore is dropped from names that are Python's own words: lambda_ stands for the option lambda.
    Raises TypeError for a value that is neither a number, nor a bool, nor a text.
    """
    texts = {}
    for key, value in values.items():
        name = key[:-1] if key.endswith("_") and keyword.iskeyword(key[:-1]) else key
        if isinstance(value, (bool, np.bool_)):
            texts[name] = "true" if value else "false"
        elif isinstance(value, (int, np.integer)):
            texts[name] = str(int(value))
        elif isinstance(value, (float, np.floating)):
            texts[name] = repr(float(value))
        elif isinstance(value, str):
            texts[name] = value
        else:
            raise TypeError("option %s.%s is %r; needed: a number, a bool or a text" % (context, name, value))
    return texts


def describe(rows, indent):
    """Return a paragraph per option, for docstrings."""
    lines = []
    for option in rows:
        unit = "" if option.unit == "-" else " " + option.unit
        lines.append("%s%s = %s%s (%s)" % (indent, option.name, option.value, unit, _range(option.range)))
        lines.append("%s    %s" % (indent, option.description))
    return "\n".join(lines)


def _range(text):
    return text[1:-1].replace(", ", " to ") if text.startswith("[") else text


def _feature_options():
    """Options of features by algorithm; empty where the package was built without features."""
    try:
        from . import _features  # pylint: disable=import-outside-toplevel
    except ImportError:
        return {}
    return {name: [Option(*row) for row in rows] for name, rows in _features.algorithm_options().items()}

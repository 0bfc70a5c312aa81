"""Options: their list for people, and their values as the text that C++ reads and checks."""

import collections
import keyword
import re

import numpy as np

from . import _core

Option = collections.namedtuple("Option", "name value range unit choices description")
Option.__doc__ = """One option of an algorithm.

name          as a keyword argument
value         the value in force: bool, int, float or str
range         the accepted values as text
unit          "-" for a plain number
choices       names and meanings of the accepted values as a dictionary; empty for other types
description   one sentence
"""


def options_from(dictionaries):
    """Return a list of Option from what C++ returns."""
    return [Option(**values) for values in dictionaries]


def options(name):
    """Return the options of a selector, of a feature algorithm or of the matching: a list of Option.

    name    a selector, optionally with a preset and with options in brackets, e.g. "gms", "lpm:v2" or
            "usac[max_seconds=0.01]": the values are those of the preset and of the brackets;
            a detector or descriptor, e.g. "orb"; "match", the options of match() and match_features(); or
            "verification", the options of verify()

    Raises ValueError for an unknown name, listing the valid ones.
    """
    # The modules of features and databases bring many libraries, so they are loaded only for what they alone know.
    if "/" in name or re.split(r"[:\[]", name)[0] in _core.selector_names():
        return options_from(_core.Selector(name, {}).options())
    algorithms = _feature_options()
    if name not in algorithms:
        algorithms.update(_verification_options())
    if name not in algorithms:
        names = _core.selector_names() + list(algorithms)
        raise ValueError(
            "unknown selector or algorithm of features '%s'%s" % (name, _core.valid_names(name, names))
        )
    return algorithms[name]


def to_text(context, values):
    """Return keyword arguments as a dictionary of texts.

    A trailing underscore is dropped from names that are Python's own words: lambda_ means the option lambda.
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


def keyword_of(name):
    """Return the keyword argument for an option: lambda_ for the option lambda."""
    return name + "_" if keyword.iskeyword(name) else name


def describe(rows, indent):
    """Return a paragraph per option, for docstrings."""
    lines = []
    for option in rows:
        unit = "" if option.unit == "-" else " " + option.unit
        lines.append(
            "%s%s=%r%s (%s)" % (indent, keyword_of(option.name), option.value, unit, _range_text(option))
        )
        lines.append("%s    %s" % (indent, option.description))
    return "\n".join(lines)


def _range_text(option):
    if isinstance(option.value, bool):
        return "False or True"
    if option.choices:
        return ", ".join(repr(choice) for choice in option.choices)
    return option.range[1:-1].replace(", ", " to ") if option.range.startswith("[") else option.range


def _feature_options():
    """Options of features by algorithm; empty where the package was built without features."""
    try:
        from . import _features  # pylint: disable=import-outside-toplevel
    except ImportError:
        return {}
    return {name: options_from(rows) for name, rows in _features.algorithm_options().items()}


def _verification_options():
    """Options of verify(); empty where the package was built without it."""
    try:
        from . import _database  # pylint: disable=import-outside-toplevel
    except ImportError:
        return {}
    return {"verification": options_from(_database.options())}

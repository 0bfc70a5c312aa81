"""The catalogue of all options, for what is generated from it: the cfg files, config/live.yaml and tables in docs/.

It needs only Python's standard library (3.8 or newer).
"""

import json
import os

PATH = os.path.join(os.path.dirname(os.path.realpath(__file__)), "catalogue.json")

# The parts of the nodelets that a change of a parameter rebuilds.
FEATURES, MATCH, SEQUENCE, REGION, FLOW = 1, 2, 4, 8, 16
MATCHER = 1
SELECTOR = 2
TRACKER = 1


def load():
    """Return the catalogue as src/programs/option_catalogue.cpp writes it."""
    with open(PATH, encoding="utf-8") as file:
        return json.load(file)


def describe(option):
    """Return the description of an option with its unit."""
    unit = option.get("unit")
    return option["description"] + (" [%s]" % unit if unit else "")


def with_choices(options, name, choices):
    """Return the options, with the values that are offered for the text `name`."""
    return [dict(option, choices=choices) if option["name"] == name else option for option in options]


def live_options(selector):
    """Return the options of a selector that are parameters of the Selector nodelet.

    These are its main parameters, the options that its presets set, and min_confidence. The parameter `options` of the
    nodelet sets the others; the seed of every selector is the one parameter `seed`.
    """
    names = {"min_confidence", *selector["main_parameter"]}
    for values in selector["presets"].values():
        names.update(values)
    return [option for option in selector["options"] if option["name"] in names]


def groups(catalogue, nodelet):
    """Return the parameters of a nodelet that can be changed at run time: (group, prefix, level, options) each."""
    own = catalogue["nodelets"][nodelet]
    matching = [
        ("match", "match_", MATCH, catalogue["matching"]),
        ("sequence", "sequence_", SEQUENCE, catalogue["sequence"]),
    ]
    if nodelet == "FeatureMatcher":
        features = catalogue["features"]
        choice = with_choices(own["changeable"], "features", features["combinations"])
        result = [("", "", FEATURES, choice), ("region", "roi_", REGION, own["region"])]
        for algorithm in features["algorithms"]:
            name = algorithm["name"]
            live = [
                dict(option, default=option.get("live_default", option["default"]))
                for option in algorithm["options"]
            ]
            result.append((name, name + "_", FEATURES, live))
        own_options = [("guided", "guided_", MATCH), ("flow", "flow_", FLOW)]
        return result + matching + [entry + (catalogue[entry[0]],) for entry in own_options]
    if nodelet == "Matcher":
        return [("", "", MATCHER, own["changeable"])] + matching
    selectors = [dict(entry, meaning="%(group)s: %(meaning)s" % entry) for entry in catalogue["selectors"]]
    choice = with_choices(own["changeable"], "selector", selectors)
    if nodelet == "Tracker":
        return [("", "", TRACKER, choice)]
    result = [("", "", SELECTOR, choice)]
    for selector in catalogue["selectors"]:
        options = live_options(selector)
        # Methods for comparison are plug-ins of the nodelet: the parameter `options` sets theirs.
        if options and selector["group"] != "reference":
            result.append((selector["name"], selector["name"] + "_", SELECTOR, options))
    return result


def add_parameters(generator, nodelet):
    """Add the parameters of a nodelet to a ParameterGenerator of dynamic_reconfigure."""
    types = {"number": "double", "integer": "int", "flag": "bool", "choice": "str", "text": "str"}

    def choices(name, values):
        prefix = "" if name == "features" else name + "_"
        constants = [
            # dynamic_reconfigure allows no quotes here.
            generator.const(
                prefix + value["name"].replace("+", "_"),
                "str",
                value["name"],
                value["meaning"].replace("'", "").replace('"', ""),
            )
            for value in values
        ]
        return generator.enum(constants, "Values of " + name)

    for group_name, prefix, level, options in groups(load(), nodelet):
        # The name of a group becomes that of a C++ variable, which cannot be `auto`.
        group = generator.add_group(group_name + "_options") if group_name else generator
        for option in options:
            name = prefix + option["name"]
            arguments = {}
            if "min" in option:
                arguments = {"min": option["min"], "max": option["max"]}
            if "choices" in option:
                arguments["edit_method"] = choices(name, option["choices"])
            group.add(name, types[option["type"]], level, describe(option), option["default"], **arguments)

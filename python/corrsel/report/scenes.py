"""What kind of scene the selectors that tell it found, counted for each dataset and kind of features."""
from .markup import best_cell, table, text_cell
from .words import SCENES, features_text, preselection_text


def counts_of(run):
    """Return (group, selector) -> scene -> number of selections, of the selectors that name a scene on any pair."""
    naming = {s for (_, s), scenes in run.scenes.items() if set(scenes) - {"", "unknown"}}
    return {key: scenes for key, scenes in run.scenes.items() if key[1] in naming and set(scenes) - {""}}


def html(run, figures):
    """Return the body of the section; its length does not depend on the number of pairs."""
    rows = []
    for (group, selector), counts in counts_of(run).items():
        texts = (group.dataset, features_text(group.features), preselection_text(group.preselection))
        counts = [counts.get(scene, 0) for scene in SCENES]
        cells = [
            best_cell(str(count), title="most frequent") if count == max(counts) else str(count)
            for count in counts
        ]
        rows.append(("", [selector] + list(map(text_cell, texts)) + cells + [str(sum(counts))]))
    head = ["Selector", "Dataset", "Features", "Preselection"]
    head += [scene.replace("_", " ") for scene in SCENES] + ["all"]
    caption = "The scene that a selector found: one count per pair and seed. \u25b2 most frequent of the row."
    return table(caption, head, rows, "results counts", long=len(rows) > 15)

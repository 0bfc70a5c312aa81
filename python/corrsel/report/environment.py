"""Machine, configuration and seeds of the run."""
import json

from markupsafe import Markup

from .markup import details, joined, paragraph, table, text_cell


def seeds_text(run):
    """Return the seeds of the run as words."""
    seeds = sorted(filter(None, run.seeds), key=lambda s: (len(s), s))
    if not seeds:
        return "none recorded"
    if len(seeds) > 12:
        text = "%d different seeds, %s to %s; each is in its row of pairs.csv"
        return text % (len(seeds), seeds[0], seeds[-1])
    return ", ".join(seeds)


def html(run, figures):
    """Return the body of the section."""
    out = [paragraph("Seeds: %s." % seeds_text(run))]
    if run.environment:
        rows = []
        for key, value in run.environment.items():
            text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
            rows.append(("", [key, text_cell(text)]))
        caption = "The machine and the software of the run."
        out.append(table(caption, ["Item", "Value"], rows, "texts", long=len(rows) > 30))
    else:
        out.append(paragraph("The environment was not recorded."))
    if run.config is None:
        out.append(paragraph("The configuration was not recorded."))
    else:
        text = Markup('<pre tabindex="0" aria-label="config.yaml">%s</pre>') % run.config.strip("\n")
        out.append(details("Configuration", text))
    return joined(out)

"""Machine, configuration and seeds of the run."""
import json

from .markup import paragraph, table
from .words import esc


def seeds_text(run):
    """Return the seeds of the run as words."""
    seeds = sorted(filter(None, run.seeds), key=lambda s: (len(s), s))
    if not seeds:
        return "none recorded"
    if len(seeds) > 12:
        return "%d different seeds, %s to %s; each is in its row of pairs.csv" % (
            len(seeds),
            seeds[0],
            seeds[-1],
        )
    return ", ".join(seeds)


def html(run, figures):
    """Return the body of the section."""
    out = [paragraph("Seeds: %s." % esc(seeds_text(run)))]
    if run.environment:
        rows = []
        for key, value in run.environment.items():
            text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
            rows.append(("", [esc(key), ('class="text"', esc(text))]))
        out.append(
            table(
                "The machine and the software of the run.",
                ["Item", "Value"],
                rows,
                "texts",
                long=len(rows) > 30,
            )
        )
    else:
        out.append(paragraph("The environment was not recorded."))
    if run.config is None:
        out.append(paragraph("The configuration was not recorded."))
    else:
        out.append("<h3>Configuration</h3>")
        out.append('<pre tabindex="0" aria-label="config.yaml">%s</pre>' % esc(run.config.strip("\n")))
    return "\n".join(out)

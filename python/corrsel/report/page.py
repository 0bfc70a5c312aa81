"""Puts the sections together into one file."""
import json
from collections import namedtuple

from markupsafe import Markup

from . import budget, curves, definitions, efficiency, environment, failures, features, guide, overall
from . import (
    opening,
    overview,
    per_pair,
    pose,
    preselected,
    results,
    robustness,
    scenes,
    stages,
    timing,
    unrelated,
    visual,
)
from .figures import FigureWriter, set_up_figures
from .markup import FOLDER, joined, render, sources
from .scopes import makes_variants, other_groups, switches_of
from .words import is_unrelated

MAX_DOUBTS = 12  # warnings about the ground truth that are shown; the rest stays in summary.json

# `files` are the tables of the run that a section is made of and does not link itself.
# Sections that are about single pairs stand last: of those, `about_pairs` returns True for the run.
Section = namedtuple("Section", "key title module shown files about_pairs", defaults=[(), lambda run: False])


def always(run):
    """Hold for every run."""
    return True


def experiment(name):
    """Return the condition of a section that belongs to an experiment of a preset."""
    return lambda run: name in run.sections


def has_poses(run):
    """Tell whether the section on poses is shown: a table of many variants tells little."""
    return "pose" in run.sections or (run.pose_summary and not makes_variants(run))


# In the report's order. Each module has html(run, figures), which returns the section's body.
SECTIONS = (
    Section("overview", "What won where", overview, always),
    Section("overall", "Every dataset", overall, experiment("overall")),
    Section("preselected", "After preselection", preselected, experiment("preselected")),
    Section("features", "Detectors and descriptors", features, experiment("features")),
    Section("robustness", "Robustness", robustness, experiment("robustness"), ("pairs.csv",)),
    Section("efficiency", "Efficiency", efficiency, experiment("efficiency"), ("scaling.csv", "summary.csv")),
    Section(
        "guide",
        "Guide: which selector when",
        guide,
        experiment("guide"),
        ("guide.csv", "pairs.csv", "scaling.csv"),
    ),
    Section(
        "unrelated",
        "Pairs of different scenes",
        unrelated,
        lambda run: "unrelated" in run.sections or any(map(is_unrelated, run.datasets)),
    ),
    Section("pose", "Pose and corners", pose, has_poses, (), pose.only_single_pairs),
    Section("budget", "Equal time", budget, experiment("budget")),
    Section("curves", "Operating curves", curves, experiment("curves")),
    Section("results", "Results", results, lambda run: not run.sections or other_groups(run)),
    Section("time", "Time before selection, and F against time in other settings", timing, always),
    Section("scenes", "Scenes that were found", scenes, scenes.counts_of, ("pairs.csv",)),
    Section("failures", "Failures and left-out pairs", failures, always, ("failures.csv", "pairs.csv")),
    Section("stages", "Time by stage", stages, lambda run: run.stages or "peak_memory_mib" in run.state),
    Section("definitions", "Definitions", definitions, always),
    Section(
        "environment",
        "Environment, configuration, seeds",
        environment,
        always,
        ("config.yaml", "environment.json"),
    ),
    Section("per_pair", "Pair by pair", per_pair, lambda run: not makes_variants(run), (), always),
    Section("visual", "Example pairs", visual, lambda run: run.images or not makes_variants(run), (), always),
)


def build(run, figures_folder=None):
    """Return the whole report as HTML; figures are also written as files where a folder is given."""
    set_up_figures()
    figures = FigureWriter(figures_folder, run.link + "figures/")
    first = opening.html(run, figures)
    sections = [
        {
            "key": s.key,
            "title": s.title,
            "body": joined([s.module.html(run, figures), sources(run, *s.files)]),
        }
        for s in sorted(SECTIONS, key=lambda s: s.about_pairs(run))
        if s.shown(run)
    ]
    return render(
        "page.html",
        title="Correspondence selection benchmark",
        run=run,
        style=Markup((FOLDER / "style.css").read_text(encoding="utf-8")),
        script=Markup((FOLDER / "script.js").read_text(encoding="utf-8")),
        state=overview.state_html(run),
        complete=overview.is_complete(run),
        doubts=[w["text"] for w in run.truth_warnings if isinstance(w, dict) and w.get("text")],
        doubt_files=sources(run, "truth_check.csv", "summary.json"),
        max_doubts=MAX_DOUBTS,
        scope=overview.scope_html(run),
        opening=first,
        lead=overview.lead(run),
        sections=sections,
        switches=json.dumps(switches_of(run)),
    )

"""Files with five faults, each of another layer, put together by chance: every one is told, with its line."""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from sim.cli.validation.faults import validate
from sim.metrics.checks import with_names
from sim.scenario import catalogue
from sim.scenario.editors.json_schema import schema
from sim.scenario.plugins import catalogue_with

pytestmark = pytest.mark.acceptance
FILES = 60
GOOD = (  # what every file has besides
    'name = "mine"\n',
    '[sensors.radar]\nkind = "surveillance_radar"\nperiod_s = 4\n',
    '[trackers.good]\nkind = "kalman"\nsensors = ["radar"]\n',
)
FAULTS = {  # layer -> some of its faults: whether it stands before all tables, and its lines, the last of them wrong
    "TOML": (
        (True, "draws = ten\n"),
        (True, "flights == 2\n"),
        (False, '[wind.events.gust]\nkind = "gust"\nat_s = 5\nlasts_s = 4\nup_mps =\n'),
    ),
    "key or kind": (
        (True, "speed_kt = 5\n"),
        (False, "[weather]\n"),
        (False, '[trackers.other]\nkind = "immm"\n'),
        (False, '[sensors.beam]\nkind = "mls"\nsector = 40\n'),
        (False, "[start]\ncros_track_m = 40\n"),
    ),
    "type": (
        (True, 'until_s = "60"\n'),
        (True, "seed = 1.5\n"),
        (False, '[sensors.dme]\nkind = "dme"\nsigma_m = "15"\n'),
        (False, "[autopilot]\nallow_orbit = 1\n"),
    ),
    "range": (
        (False, "[wind]\nspeed_kt = 400\n"),
        (False, "[runway]\nlatitude_deg = 89\n"),
        (False, "[air]\nqnh_hpa = 29.92\n"),
        (False, '[[checks]]\nmetric = "bank_deg"\nmax = 30\nconfidence = 0.9\nshare = 1.5\n'),
    ),
    "name": (
        (False, '[trackers.deaf]\nkind = "kalman"\nsensors = ["radra"]\n'),
        (False, '[trackers.heir]\nkind = "kalman"\nsensors = ["radar"]\nhandover = "godo"\n'),
        (False, '[[contrasts]]\nof = "good"\nagainst = "bad"\n'),
        (False, '[[sensor_faults]]\nat_s = 5\nerror_factor = 2\nsensor = "rader"\n'),
        (False, '[[checks]]\nmax = 30\nmetric = "bnk_deg"\n'),
    ),
    "aircraft": (
        (False, '[aircraft]\nmodel = "an62"\n'),
        (False, '[aircraft]\nmodel = "an26"\nmass_kg = 90000\n'),
        (False, '[aircraft]\nmodel = "an26"\n[aircraft.factors]\nlift = 1.1\n'),
    ),
    "preparation": (
        (False, '[trackers.fine]\nkind = "saturated_control"\nsensors = ["radar"]\nsub_step_s = 1e-4\n'),
        (False, '[[checks]]\nmax = 3\nmetric = "trackers.nobody.anees"\n'),
    ),
}


def drawn(generator: np.random.Generator) -> tuple[str, set[int]]:
    """A file of five faults of five layers, and their lines."""
    while True:
        layers = generator.choice(sorted(FAULTS), 5, replace=False)
        chosen = [FAULTS[layer][generator.integers(len(FAULTS[layer]))] for layer in layers]
        single = [re.match(r"\[([\w.]+)\]", text)[1] for first, text in chosen if not first and text[1] != "["]
        if len(set(single)) == len(single):
            break
    tables = [(text, True) for first, text in chosen if not first] + [(text, False) for text in GOOD[1:]]
    generator.shuffle(tables)
    content, wanted = "", set[int]()
    for text, is_fault in [(GOOD[0], False), *((text, True) for first, text in chosen if first), *tables]:
        content += text
        wanted |= {content.count("\n")} if is_fault else set()
    return content, wanted


def test_five_faults_of_five_layers_are_told_each_with_its_line(tmp_path, row):
    generator, found, beside = np.random.default_rng(19), 0, list[str]()
    for _ in range(FILES):
        content, wanted = drawn(generator)
        (file := tmp_path / "mine.toml").write_text(content)
        told = validate(str(file), {}, catalogue_with(())).faults
        lines = [int(re.match(rf"{re.escape(str(file))}:(\d+): ", fault)[1]) for fault in told]
        found += len(wanted & set(lines))
        beside += [fault for fault, line in zip(told, lines, strict=True) if line not in wanted]
        if len(told) != 5 or set(lines) != wanted:
            print(content, "\n".join(told), wanted)
    asked = 5 * FILES
    row("faults told with their line, of 5 in 5 layers of 60 files", f"{asked}", f"{found}", found == asked)
    row("told besides", "0", f"{len(beside)}", not beside)
    assert (found, beside) == (asked, [])


def test_bundled_files_are_valid_by_the_schema(row):
    validator = Draft202012Validator(with_names(schema()))
    names = [*catalogue.scenarios(), *catalogue.studies()]
    valid = [validator.is_valid(tomllib.loads(catalogue.bundled(name).read_text(encoding="utf-8"))) for name in names]
    row("bundled files valid by the JSON Schema", f"all of {len(names)}", f"{sum(valid)}", all(valid))
    assert all(valid)

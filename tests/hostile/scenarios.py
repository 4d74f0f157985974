"""Scenario files that are hostile or broken, and what must be said of each: a regular expression."""

from __future__ import annotations

from tests.hostile.scenario_base import CAPTURE

LEG = "[[route.legs]]\nfrom_m = [{0}e3, 0]\nto_m = [{1}e3, 0]\nspeed_mps = 70\nheight_m = 500\n"
FACTORS = "[aircraft.factors]\nlift_slope = "
AXES = "[study.axes]\n'wind.speed_mps' = "

SCENARIOS: dict[str, tuple[str | bytes, str]] = {
    "half": (CAPTURE[:40], "not TOML"),
    "not_utf_8": (CAPTURE.encode() + b'colour = "\xe9"', "not UTF-8"),
    "utf_16": (CAPTURE.encode("utf-16"), "not UTF-8"),
    "zero_byte": (CAPTURE + "\0", "not TOML"),
    "old_mac_lines": (CAPTURE.replace("\n", "\r"), "not TOML"),
    "too_large": (CAPTURE + "# " + "x" * (1 << 20), "larger than 1048576 bytes"),
    "deep_list": ("a = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
    "deep_table": ("[" + ".".join("a" * 5000) + "]", "nested too deeply"),
    "deep_key": (".".join("a" * 20_000) + " = 1", "nested too deeply"),
    "twice": (CAPTURE + "[start]\nleg = 0", "Cannot declare"),
    "number_of_5000_digits": (CAPTURE + f"[wind]\nspeed_mps = 1{'0' * 5000}", "4300 digits"),
    "number_beyond_floats": (CAPTURE + f"[wind]\nspeed_mps = 1{'0' * 400}", "must be a number"),
    "factor_beyond_floats": (CAPTURE + FACTORS + f"1{'0' * 400}", "must be a number"),
    "axis_beyond_floats": (CAPTURE + AXES + f"{{ uniform = [0, 1{'0' * 400}] }}", "finite numbers"),
    "number_as_text": (CAPTURE.replace("until_s = 2", "until_s = '2'"), "must be a number"),
    "date_for_number": (CAPTURE.replace("until_s = 2", "until_s = 1979-05-27"), "must be a number"),
    "two_units": (CAPTURE + "[wind]\nspeed_mps = 3\nspeed_kt = 6", "two spellings of one value"),
    "units_of_another_kind": (CAPTURE + "[wind]\nspeed_m = 3", "write it as speed_mps"),
    "unit_of_an_angle_for_a_length": (
        CAPTURE.replace("height_m", "height_deg"),
        "'height_m' is missing, 'height_deg' is no unit of it",
    ),
    "many_keys": (CAPTURE + "".join(f"k{i} = 1\n" for i in range(10_000)), "no such key"),
    "many_trackers": (
        CAPTURE + "".join(f"[trackers.t{i}]\nkind = 'kalman'\n" for i in range(3_000)),
        "3001 are more than the 50",
    ),
    "many_legs": (
        "name = 'x'\n[route]\nkind = 'legs'\n" + "".join(LEG.format(i, i + 1) for i in range(1500)),
        "must be at most 1000000",
    ),
    "legs_that_do_not_join": (
        "name = 'x'\n[route]\nkind = 'legs'\n" + LEG.format(0, 9) + LEG.format(1, 2),
        "must join",
    ),
    "colours_in_a_key": (CAPTURE + '"a\\u001b[31m\\nshortfinal: good" = 1', r"a\\x1b\[31m\\nshortfinal: good: no such"),
    "lines_in_a_kind": (CAPTURE.replace('"kalman"', '"a\\nb"'), r"no kind 'a\\nb'"),
    "lines_in_a_name": (CAPTURE.replace("[sensors.radar]", '[sensors."a\\nb"]'), r"\[sensors.a\\nb\]"),
    "lines_in_a_metric": (CAPTURE + "[[checks]]\nmetric = 'a\\nb'\nmax = 1", "no metric"),
    "turned_writing": (CAPTURE.replace('"short"', '"\u202etrohs"'), "must start with a letter"),
    "name_that_leaves": (CAPTURE.replace('"short"', '"../../short"'), "must start with a letter"),
    "aircraft_that_leaves": (CAPTURE + "[aircraft]\nmodel = '../../../etc'", "must hold"),
    "design_of_nonsense": (CAPTURE + "[designed]\nk1 = 'x'", r"\[designed\]"),
    "flights_without_end": (CAPTURE.replace("draws = 1", "flights = 1000000000"), "at most 100000"),
    "sensor_without_rest": (CAPTURE.replace("period_s = 0.5", "period_s = 1e-3"), "finer than 1/120 s"),
    "empty_lists": (CAPTURE.replace('kind = "kalman"', 'kind = "kalman"\nsensors = []'), "sensors: must not be empty"),
}

"""explain(): what a scenario resolves to, in plain text: route, trims, modes, gains, limits, checks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from aircraft.errors import TrimError
from aircraft.linearise import linearise
from aircraft.modes import LEVEL_SOURCE, flying_qualities, modes
from aircraft.trim import trim
from autopilot.limit_cycles import limited_loop
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import linear_onset, margins
from sim.cli.terminal import table
from sim.errors import OutputError
from sim.estimation.setup import check, told
from sim.experiment import read
from sim.files import whole
from sim.flight import swings
from sim.flight.arrivals import vectoring
from sim.flight.departures import in_words
from sim.flight.preparation import MODEL_TIME_LIMIT, Prepared, prepare
from sim.flight.record import Flight, runs
from sim.flight.weather import words
from sim.interchange.clocks import in_words as clock_words
from sim.metrics import windshear
from sim.observation import faults
from sim.reporting.drawing import svg
from sim.reporting.loop_figures.bode import bode
from sim.reporting.loop_figures.step import step
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.model import Scenario
from sim.scenario.plugins import Plugins, catalogue_with
from sim.scenario.reading import Source
from sim.scenario.tables import Check
from sim.workers.isolation import run_isolated


def explain(scenario: Source | Scenario, overrides: Mapping[str, Any] | None = None, *, plugins: Plugins = ()) -> str:
    """What a scenario resolves to: route, trim, modes, gains, limits, checks; all that is given is as for ``sim.read``.

    Raises ``ScenarioError`` for what cannot be flown.
    """
    if not isinstance(scenario, Scenario):
        scenario = read(scenario, overrides, plugins=plugins)
    elif overrides:
        scenario = read(scenario.tables, overrides, plugins=catalogue_with(plugins).also(scenario.parts))
    prepared = prepare(scenario)
    check(prepared)
    parts = [_head(prepared), _route(prepared), *_vectors(prepared), *_navigation(prepared)]
    if prepared.recording is not None:
        parts.append(_recording(prepared.recording))
    elif scenario.aircraft.model != "point_mass":
        parts.append(run_isolated(scenario, MODEL_TIME_LIMIT, _aircraft, prepared))
        parts += windshear.outlook(prepared)
    parts.append(f"law {scenario.mode}: {_law(prepared)}")
    rows: list[tuple[str, ...]]
    if scenario.departures:
        rows = [("the law is left at s", "what no tracker knows")]
        rows += [(f"{one.at:.0f}", in_words(one)) for one in sorted(scenario.departures, key=lambda one: one.at)]
        parts.append("\n".join(table(rows, 2)))
    if scenario.sensor_faults:
        rows = [("a sensor fails at s", "what no tracker knows")]
        rows += [
            (f"{one.at:.0f}", faults.in_words(one)) for one in sorted(scenario.sensor_faults, key=lambda one: one.at)
        ]
        parts.append("\n".join(table(rows, 2)))
    if scenario.sensors:
        kinds = {name: str(entry["kind"]) for name, entry in scenario.tables["sensors"].items()}
        rows = [("sensor", "kind", "measures", "every s")]
        rows += [(n, kinds[n], ", ".join(s.channels), f"{s.period:.3g}") for n, s in scenario.sensors.items()]
        parts.append("\n".join(table(rows, 3)))
    if scenario.trackers:
        rows = [("tracker", "kind", "listens to", "is told")]
        rows += [
            (name, one.kind, ", ".join(one.sensors), told(prepared, one.cls) or "-")
            for name, one in scenario.trackers.items()
        ]
        parts.append("\n".join(table(rows, 4)))
    if scenario.contrasts:
        rows = [("contrast of", "against", "called")]
        rows += [(one.of, one.against, one.name or "-") for one in scenario.contrasts]
        parts.append("\n".join(table(rows, 3)))
    if scenario.checks:
        rows = [("check", "during", "limit", "source")]
        rows += [(c.name or c.metric, _during(c.during), _limits(c), c.source) for c in scenario.checks]
        parts.append("\n".join(table(rows, 4)))
    parts += [f"warning: {warning}" for warning in prepared.warnings]
    return "\n\n".join(parts)


def draw_loops(scenario: Scenario, wanted: Mapping[str, Path]) -> list[Path]:
    """Write the figures "bode" and "step" of a scenario's loops as SVG; the files, in order.

    Raises ``OutputError`` for a name that does not end in .svg or cannot be written, before anything is drawn where
    the name tells it, and ``ScenarioError`` where there is no route loop.
    """
    for path in wanted.values():
        if path.suffix != ".svg":
            raise OutputError(f"{path}: name it NAME.svg")
    if not wanted:
        return []
    prepared = prepare(scenario)
    law, loop = LateralNavigation.of(prepared.law), run_isolated(scenario, MODEL_TIME_LIMIT, prepared.route_loop)
    assert law is not None
    for name, path in wanted.items():
        figure, title = {"bode": (bode, "route loop"), "step": (step, "bank loop and route loop")}[name]
        text = svg.written(figure(loop, law), f"{scenario.name}: {title}")
        with whole(path) as partial:
            partial.write_text(text.replace("<svg ", '<svg style="background:#fff" ', 1) + "\n", encoding="utf-8")
    return list(wanted.values())


def _head(prepared: Prepared) -> str:
    s = prepared.scenario
    mass = f", {s.aircraft.mass:.0f} kg" if s.aircraft.mass else ""
    flies = f"{s.aircraft.model}{mass}" if s.record is None else f"a flight recorded in {s.record.file}"
    if s.record is not None and not s.record.known:
        flies = "a flight that only recorded plots tell of"
    return "; ".join((f"{s.name}: {flies}", *words(s), f"seed {s.seed}"))


def _recording(flight: Flight) -> str:
    """When it was, how long, and its phases where they are known."""
    if not flight.known:
        at = "" if flight.utc is None else f" from {clock_words(flight.utc + flight.time[0], True)}"
        return f"plots{at} for {flight.time[-1] - flight.time[0]:.0f} s; {flight.reason}"
    date = datetime.fromtimestamp(flight.utc or 0.0, UTC).isoformat(sep=" ", timespec="seconds")
    rows: list[tuple[str, ...]] = [("phase", "from s", "m from the threshold", "height m", "ground speed m/s")]
    for first, _ in runs(flight.phase):
        s = flight.state
        figures = s.time[first], math.hypot(s.north[first], s.east[first]), s.height[first], s.ground_speed[first]
        rows.append((flight.phases[int(flight.phase[first])], *(f"{figure:.0f}" for figure in figures)))
    return f"recorded from {date} for {flight.time[-1]:.0f} s; {flight.reason}\n" + "\n".join(table(rows, 1))


def _route(prepared: Prepared) -> str:
    air = prepared.scenario.air
    rows = [("leg", "course deg", "length m", "true m/s", "equivalent m/s", "height m", "turn at m to go")]
    for number, leg in enumerate(prepared.route.legs):
        turn = "-"
        if number + 1 < len(prepared.route.legs):
            turn = f"{prepared.route.turn(number, leg.speed, prepared.law.bank_limit).entry:.0f}"
        course = math.degrees(leg.course) % 360
        speeds = f"{leg.speed:.1f}", f"{leg.speed * air.equivalent_share(leg.height):.1f}"
        rows.append((str(number), f"{course:.1f}", f"{leg.length:.0f}", *speeds, f"{leg.height:.0f}", turn))
    landing = prepared.autopilot.landing
    end = "" if prepared.scenario.has_route else "\nthe final of the runway, without speeds, since no route is told"
    if landing is not None and not end:
        end = (
            f"\nglide path {math.degrees(landing.glide_path):.2f} deg at {landing.approach_speed:.1f} m/s true, "
            f"{landing.approach_speed * air.equivalent_share(prepared.route.legs[-1].height):.1f} equivalent where it "
            f"begins, flaps {math.degrees(landing.flaps):.0f} deg"
        )
    if not air.is_standard:
        level = prepared.route.legs[-1].height
        shown = air.altimeter(level) - air.altimeter(0.0)
        end += f"\nheights are true: {level:.0f} m above the threshold, where an altimeter shows {shown:.0f} m"
    return "\n".join(table(rows, 0)) + end


def _vectors(prepared: Prepared) -> list[str]:
    """The headings that are given, where a route is vectored, and what the law and the speeds do then."""
    scenario, route = prepared.scenario, prepared.scenario.route
    if not isinstance(route, VectoredTable):
        return []
    last = vectoring.vectors(scenario, route)[-1].time
    rows = [("vector from s on", "course deg", "heading deg", "to the final deg"), *vectoring.in_words(scenario, route)]
    speeds = ", ".join(f"{speed:.1f} m/s {where}" for where, speed, _ in route.levels)
    return [
        "\n".join(table(rows, 0))
        + f"\nfrom the {'left' if route.sign > 0.0 else 'right'}; the last heading is to meet the extended centreline "
        f"{vectoring.met(scenario, route):.0f} m before the aiming point, {last:.0f} s after it is given; "
        f"the law takes over {route.arm_late:.1f} s after it would turn in\ntrue airspeed: {speeds}"
    ]


def _navigation(prepared: Prepared) -> list[str]:
    """What the autopilot's own navigation errs by."""
    errors = prepared.scenario.navigation_errors
    if errors is None:
        return []
    bends = [f"{math.degrees(bend):.3f} deg" for bend in (errors.localiser_bend, errors.glide_path_bend)]
    return [
        f"navigation errs: localiser {bends[0]} and glide path {bends[1]} rms over {errors.bend_length:.0f} m, course "
        f"line {math.degrees(errors.localiser_bias):+.3f} deg, wind {errors.wind:.1f} m/s at first; smoothed in "
        f"{errors.smoothing:.1f} s"
    ]


def _aircraft(prepared: Prepared) -> str:
    airframe = prepared.airframe.load()
    landing, legs = prepared.autopilot.landing, prepared.route.legs
    conditions = [(leg.speed, prepared.autopilot.flaps, 0.0, 0.0, leg.height) for leg in legs]
    if landing is not None:
        conditions.append((landing.approach_speed, landing.flaps, 1.0, -landing.glide_path, 0.5 * legs[-1].height))
    trims: list[tuple[str, ...]] = [("speed m/s", "flaps deg", "path deg", "alpha deg", "throttle", "elevator")]
    natural = [("speed m/s", "mode", "frequency rad/s", "damping", "time s")]
    grades = [("speed m/s", "requirement", "value", "level")]
    for speed, flaps, gear, path, height in dict.fromkeys(conditions):
        try:
            steady = trim(airframe, speed, path, height, flaps, gear)
            linear = linearise(airframe, steady)
            found = modes(linear)
        except (TrimError, ValueError) as error:
            trims.append((f"{speed:.1f}", str(error), "", "", "", ""))
            continue
        controls = steady.controls
        angles = [f"{math.degrees(x):.2f}" for x in (flaps, path, steady.initial.angle_of_attack)]
        trims.append((f"{speed:.1f}", *angles, f"{controls.throttle:.3f}", f"{controls.elevator:+.3f}"))
        for mode in found:
            paired = mode.root.imag != 0.0
            own = (f"{mode.natural_frequency:.3f}", f"{mode.damping:.3f}") if paired else ("-", "-")
            natural.append((f"{speed:.1f}", mode.name, *own, f"{mode.time_constant:.2f}"))
        for verdict in flying_qualities(linear):
            asked = verdict.requirement
            name = f"{asked.mode} {asked.quantity}".replace("_", " ")
            value = "no" if math.isinf(verdict.value) else f"{verdict.value:.3g} {asked.unit}".strip()
            grades.append((f"{speed:.1f}", name, value, str(verdict.level) if verdict.level < 4 else "none"))
    return "\n\n".join(
        (
            "trim, engines and controls as shares of full travel\n" + "\n".join(table(trims, 0)),
            "modes of the bare aircraft; time = to change e-fold, negative where it grows\n"
            + "\n".join(table(natural, 2)),
            f"levels by {LEVEL_SOURCE}\n" + "\n".join(table(grades, 2)),
        )
    )


def _law(prepared: Prepared) -> str:
    """The law's own description, and for a route law that flies an aircraft the margins of its loop."""
    if prepared.recording is not None:
        return f"as trackers are told, whatever was flown\n{prepared.law.explain()}"
    text = f"{prepared.law.explain()}; bank loop {prepared.designed.bank_bandwidth:.2f} rad/s"
    route_law = LateralNavigation.of(prepared.law)
    return f"{text}\n{_route_loop(prepared, route_law)}" if route_law and prepared.has_route_loop else text


def _route_loop(prepared: Prepared, law: LateralNavigation) -> str:
    """Margins of the loop that the law closes on its first leg, and the oscillation that its limits can sustain."""
    loop = run_isolated(prepared.scenario, MODEL_TIME_LIMIT, prepared.route_loop)
    found, linear = margins(loop, law), linear_onset(loop, law.bank_limit)
    limited = limited_loop(loop, law.bank_limit, prepared.autopilot.roll_rate_limit)
    words = swings.in_words(limited, law) or "none, every oscillation fades"
    if law == prepared.designed.law and prepared.scenario.autopilot.estimate_lag == 0.0:
        speed = max(leg.speed for leg in prepared.route.legs)
        slowed = swings.slowness(loop, prepared.designed, speed, limited.rate_limit)
        words += f"; {slowed}" if slowed else ""
    return (
        f"sampled loop: gain margin {found.gain:.2f}, phase margin {math.degrees(found.phase):.0f} deg; laws from "
        f"{linear:.2f} rad/s ({linear / loop.bandwidth:.2f} of the bank loop) are unstable\n"
        f"limit cycle by theory: {words}"
    )


def _during(during: str | tuple[str, ...]) -> str:
    return during if isinstance(during, str) else ", ".join(during)


def _limits(check: Check) -> str:
    low, high, share = check.min, check.max, check.required_share
    limits = " ".join(f"{sign} {value:g}" for sign, value in ((">=", low), ("<=", high)) if value is not None)
    if share is None or check.confidence is None:
        return limits
    return f"{limits} in {100 * share:g} % of flights, {100 * check.confidence:g} % confidence"

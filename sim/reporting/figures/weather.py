"""What the air did: the wind met along the flight, its profile with height, an event from the side, its spectra."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from aircraft.turbulence import across_spectrum, along_spectrum
from aircraft.turbulence_intensity import intensity
from aircraft.wind_event import WindEvent
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.weather import air, kind_in_words
from sim.metrics.windshear import averaged_f_factor
from sim.reporting.drawing import contours
from sim.reporting.drawing.colours import BLUE_RED, Colours, add_scale, mixed
from sim.reporting.drawing.figure import Box, Drawing, Legend, Panel
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, over_time, pad, phase_strip
from sim.reporting.figures.thinning import where

HALF = 0.47  # of the width, of each of two panels side by side
STRIP = 0.17  # in, of the names of the phases
HIGHEST = 700.0  # m, of the profiles at least
ARROWS = (26, 11)  # of the section through an event, along and up
ARROW_SCALE = 22.0  # arrows as long as the greatest wind would lie so often across the figure
SHADE, LEVELS = 0.6, 16  # of the colours on white, and their steps
SECTION = 300.0  # m, its height at least
HAZARD = 0.105  # F over a kilometre at which a windshear system must warn [FAA TSO-C117a, from memory]
LAYERS, LEAST = 10, 90  # layers of height, and records that a layer must have to be shown
LEVEL = 30.0  # m about the height of the leg: level flight
WINDOW = 2048  # records of one spectrum, 68 s
FOLDED = 30.0  # rad/s; above, a record at 30 Hz shows more than there is


def weather_charts(flight: Flight, scenario: Any) -> Iterator[tuple[str, Drawing, str]]:
    """(title, figure, caption) of everything in the air of this scenario besides a steady wind."""
    table = scenario.wind
    if table.profile is None and not table.events and table.intensity == 0.0:
        return
    yield (
        "Wind met",
        wind_history(flight, bool(table.events)),
        "Wind at the aircraft along and across its course, and upwards; the record of the flight, not the model."
        + (
            " Below: the rate of climb over airspeed that the air takes away, averaged over a kilometre; dashed, where "
            "a windshear system must warn."
            if table.events
            else ""
        ),
    )
    if table.profile is not None or table.intensity > 0.0:
        gusts = turbulence_met(flight, scenario)
        yield (
            "Wind and turbulence over height",
            profiles(flight, scenario, gusts),
            "Lines: as the scenario says. Dots: the flight, in layers of a tenth of its height; mean wind with all "
            "events, turbulence without them.",
        )
        spectrum = spectra(flight, scenario, gusts) if table.intensity > 0.0 else None
        if spectrum is not None:
            yield (
                "Spectra of the turbulence",
                spectrum,
                "Of the wind met on the longest level stretch, over circular frequency; lines: Dryden's by MIL-F-8785C "
                "at that height and airspeed, which fall with the square of the frequency.",
            )
    for name, event in table.events.items():
        standing = event.standing()
        if standing is not None and standing.outline():
            yield (
                f"{kind_in_words(scenario, name).capitalize()} {name}",
                section_through(flight, scenario, standing),
                "Wind in the upright plane through its centre along the final course, with the flight as seen from "
                "beside it. Heights are exaggerated, the slope of the arrows is not.",
            )


def wind_history(flight: Flight, with_energy: bool) -> Drawing:
    """Figure of the wind at the aircraft over time."""
    state = flight.state
    north, east, up = flight.wind
    along = np.cos(state.course), np.sin(state.course)
    head = -(north * along[0] + east * along[1])
    right = east * along[0] - north * along[1]
    heights = (1.2, 0.8, 0.8) if with_energy else (1.2, 0.8)
    figure, (strip, level, vertical, *rest) = style.panels(STRIP, *heights)
    phase_strip(strip, flight)
    over_time(level, flight, head, colour=style.BLUE, label="headwind")
    over_time(level, flight, right, colour=style.ORANGE, label="from the left")
    level.y.label = "wind, m/s"
    pad(level, 4.0, 0.2)
    level.legend = Legend("upper left", 2)
    over_time(vertical, flight, up, colour=style.GREEN)
    vertical.y.label = "upwards, m/s"
    pad(vertical, 2.0)
    for axes in rest:
        over_time(axes, flight, averaged_f_factor(flight), colour=style.VERMILION)
        axes.rule(y=HAZARD, width=0.7, dashes=(4, 3))
        axes.y.label = "F over 1 km"
        pad(axes, 0.1)
    for axes in (level, vertical, *rest):
        axes.rule(y=0.0, order=1.0)
    strip.x.label = "time, s"
    return figure


def profiles(flight: Flight, scenario: Any, gusts: np.ndarray) -> Drawing:
    """Figure of mean wind and turbulence over height, as specified and as flown."""
    table, state = scenario.wind, flight.state
    top = max(HIGHEST, 1.1 * float(np.max(state.height)))
    heights = np.linspace(1.0, top, 200)
    figure, (speed,) = style.panels(2.4)
    left, up, whole, high = speed.box
    speed.box = Box(left, up, HALF * whole, high)
    spread = Panel(Box(left + (1.0 - HALF) * whole, up, HALF * whole, high), y=speed.y)
    spread.numbered = True, False
    figure.panels.append(spread)

    mean = np.hypot(*np.array([table.at(float(height)) for height in heights]).T)
    speed.line(mean, heights, colour=style.BLUE, label="mean wind")
    said = [intensity(float(height), table.intensity) for height in heights]
    if table.intensity > 0.0:
        spread.line([now.sigma_along for now in said], heights, colour=style.ORANGE, label="along, across")
        spread.line([now.sigma_up for now in said], heights, colour=style.GREEN, label="upwards")
    met = flight.wind
    edges = np.linspace(0.0, float(np.max(state.height)) + 1.0, LAYERS + 1)
    layer = np.digitize(state.height, edges)
    for number in np.unique(layer):
        among = layer == number
        if among.sum() < LEAST:
            continue
        height = float(state.height[among].mean())
        north, east = met[0, among].mean(), met[1, among].mean()
        speed.points(math.hypot(north, east), height, colour=style.BLUE, marker="o", size=3.5)
        if table.intensity > 0.0:
            level = math.sqrt(float(np.mean(gusts[:2, among] ** 2)))
            spread.points(level, height, colour=style.ORANGE, marker="o", size=3.5)
            rising = math.sqrt(float(np.mean(gusts[2, among] ** 2)))
            spread.points(rising, height, colour=style.GREEN, marker="o", size=3.5)
    speed.x.limits = spread.x.limits = 0.0, None
    speed.y.limits = 0.0, top
    speed.y.label = "height, m"
    speed.x.label = "wind speed, m/s"
    spread.x.label = "standard deviation of the turbulence, m/s"
    for axes in (speed, spread):
        axes.legend = Legend("upper left")
    return figure


def turbulence_met(flight: Flight, scenario: Any) -> np.ndarray:
    """(3, k) m/s: the wind met minus mean wind, shear and events; along, right and up of the mean wind."""
    state, table = flight.state, scenario.wind
    still = air(table, scenario.runway).velocity
    places = zip(flight.time, state.north, state.east, state.height, state.airspeed, strict=True)
    known = np.array([still(t, (n, e, h), v) for t, n, e, h, v in places]).T
    north, east, up = flight.wind - known
    wind = table.steady
    axis = scenario.runway.heading if table.strength == 0.0 else math.atan2(wind[1], wind[0])
    c, s = math.cos(axis), math.sin(axis)
    return np.array((c * north + s * east, c * east - s * north, up))


def spectra(flight: Flight, scenario: Any, gusts: np.ndarray) -> Drawing | None:
    """Figure of the spectra along, across and up on the longest level stretch; None where it is short.

    ``gusts`` (3, k) m/s are those of ``turbulence_met``.
    """
    level = np.array([leg.height for leg in flight.route.legs])[flight.leg]
    stretches = where(np.abs(flight.state.height - level) < LEVEL)
    first, last = max(stretches, key=lambda ends: ends[1] - ends[0], default=(0, 0))
    if last - first < WINDOW:
        return None
    airspeed = float(flight.state.airspeed[first:last].mean())
    now = intensity(float(flight.state.height[first:last].mean()), scenario.wind.intensity)
    figure, axes = style.grid(1, 3, 1.9)
    for panel, gust, name in zip(axes, gusts[:, first:last], ("along the mean wind", "across", "upwards"), strict=True):
        frequency, density = spectrum(gust)
        shown = (frequency > 0.0) & (frequency < FOLDED)
        sigma, length = (now.sigma_up, now.length_up) if name == "upwards" else (now.sigma_along, now.length_along)
        form = along_spectrum if name.startswith("along") else across_spectrum
        panel.x.scale = panel.y.scale = LOGARITHMIC
        panel.line(frequency[shown], density[shown], colour=style.SKY, width=0.8)
        panel.line(frequency[shown], form(frequency[shown], airspeed, sigma, length))
        panel.title = name
    axes[0].y.label = "density, (m/s)\u00b2 / (rad/s)"
    axes[0].x.label = "circular frequency, rad/s"
    return figure


def spectrum(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(circular frequency, one-sided density): the mean over windows that overlap by half, each under a cosine."""
    taper = np.hanning(WINDOW)
    starts = range(0, len(values) - WINDOW + 1, WINDOW // 2)
    power = np.mean([np.abs(np.fft.rfft(taper * values[a : a + WINDOW])) ** 2 for a in starts], axis=0)
    return 2.0 * np.pi * np.fft.rfftfreq(WINDOW, RECORD_STEP), power * RECORD_STEP / (np.pi * np.sum(taper**2))


def section_through(flight: Flight, scenario: Any, event: WindEvent) -> Drawing:
    """Figure of a standing wind in the upright plane through the middle of its outline, along the final course."""
    runway, state = scenario.runway, flight.state
    edge_past, edge_right = runway.from_local(*np.array(event.outline()).T)
    middle, right = (float(edge.min() + edge.max()) / 2 for edge in (edge_past, edge_right))
    reach = float(np.ptp(edge_past))
    past, _ = runway.from_local(state.north, state.east)
    near = (np.abs(past - middle) < reach) & (flight.leg == flight.leg.max())
    top = max(SECTION, 1.1 * float(np.max(state.height[near], initial=0.0)))
    forward = runway.to_local(1.0, 0.0)
    airspeed = float(np.mean(state.airspeed))

    def section(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tailwind and rising wind over x along and z up, m/s."""
        places = [[(*runway.to_local(float(a), right), float(h)) for a in x] for h in z]
        wind = np.array([[event.velocity(0.0, place, airspeed) for place in row] for row in places])
        return wind[..., 0] * forward[0] + wind[..., 1] * forward[1], wind[..., 2]

    figure, (axes,) = style.panels(2.5)
    axes.grid = ""
    along, heights = np.linspace(middle - reach, middle + reach, 81), np.linspace(0.0, top, 41)
    tail, _ = section(along, heights)
    most = max(float(np.abs(tail).max()), 1.0)
    shades = Colours([mixed(colour, SHADE) for colour in BLUE_RED], -most, most)
    levels = np.linspace(-most, most, LEVELS + 1)
    tail = np.clip(tail, -most * (1 - 1e-9), most * (1 - 1e-9))
    for low, high, colour in zip(levels[:-1], levels[1:], shades.of((levels[1:] + levels[:-1]) / 2), strict=True):
        axes.area(contours.regions(along, heights, tail, low, high), colour, order=0.5)
    add_scale(figure, shades, "tailwind, m/s")
    x, z = np.linspace(middle - reach, middle + reach, ARROWS[0]), np.linspace(0.04, 0.96, ARROWS[1]) * top
    points = axes.box.width / (ARROW_SCALE * most)  # per m/s
    places = np.meshgrid(x, z)
    axes.arrows(
        *map(np.ravel, places),
        *(points * np.ravel(wind) for wind in section(x, z)),
        colour="#444444",
        width=0.6,
        head=3.0,
    )
    by_phase(axes, flight, past, state.height, near)
    axes.x.limits, axes.y.limits = (middle - reach, middle + reach), (0.0, top)
    axes.x.label = "distance past the threshold, m"
    axes.y.label = "height, m"
    return figure

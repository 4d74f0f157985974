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
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, over_time, pad, phase_strip
from sim.reporting.figures.thinning import where

STRIP = 0.17  # in, of the names of the phases
HIGHEST = 700.0  # m, of the profiles at least
ARROWS = (26, 11)  # of the section through an event, along and up
SECTION = 300.0  # m, its height at least
HAZARD = 0.105  # F over a kilometre at which a windshear system must warn [FAA TSO-C117a, from memory]
LAYERS, LEAST = 10, 90  # layers of height, and records that a layer must have to be shown
LEVEL = 30.0  # m about the height of the leg: level flight
WINDOW = 2048  # records of one spectrum, 68 s
FOLDED = 30.0  # rad/s; above, a record at 30 Hz shows more than there is


def weather_charts(flight: Flight, scenario: Any) -> Iterator[tuple[str, Any, str]]:
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


def wind_history(flight: Flight, with_energy: bool) -> Any:
    """Figure of the wind at the aircraft over time."""
    state = flight.state
    north, east, up = flight.wind
    along = np.cos(state.course), np.sin(state.course)
    head = -(north * along[0] + east * along[1])
    right = east * along[0] - north * along[1]
    heights = (1.2, 0.8, 0.8) if with_energy else (1.2, 0.8)
    figure, (strip, level, vertical, *rest) = style.panels(STRIP, *heights)
    phase_strip(strip, flight)
    over_time(level, flight, head, color=style.BLUE, label="headwind")
    over_time(level, flight, right, color=style.ORANGE, label="from the left")
    level.set_ylabel("wind, m/s")
    pad(level, 4.0, 0.2)
    level.legend(loc="upper left", ncols=2)
    over_time(vertical, flight, up, color=style.GREEN)
    vertical.set_ylabel("upwards, m/s")
    pad(vertical, 2.0)
    for axes in rest:
        over_time(axes, flight, averaged_f_factor(flight), color=style.VERMILION)
        axes.axhline(HAZARD, color=style.BLACK, linewidth=0.7, dashes=(4, 3))
        axes.set_ylabel("F over 1 km")
        pad(axes, 0.1)
    for axes in (level, vertical, *rest):
        axes.axhline(0.0, color=style.BLACK, linewidth=0.5, zorder=1)
    (rest[-1] if rest else vertical).set_xlabel("time, s")
    return figure


def profiles(flight: Flight, scenario: Any, gusts: np.ndarray) -> Any:
    """Figure of mean wind and turbulence over height, as specified and as flown."""
    table, state = scenario.wind, flight.state
    top = max(HIGHEST, 1.1 * float(np.max(state.height)))
    heights = np.linspace(1.0, top, 200)
    figure, (speed,) = style.panels(2.4)
    box = speed.get_position()
    width = 0.47 * box.width
    speed.set_position((box.x0, box.y0, width, box.height))
    spread = figure.add_axes((box.x1 - width, box.y0, width, box.height), sharey=speed)
    spread.tick_params(labelleft=False)
    speed.yaxis.set_label_coords(-0.56 / (width * style.WIDTH), 0.5)

    mean = np.hypot(*np.array([table.at(float(height)) for height in heights]).T)
    speed.plot(mean, heights, color=style.BLUE, label="mean wind")
    said = [intensity(float(height), table.intensity) for height in heights]
    if table.intensity > 0.0:
        spread.plot([now.sigma_along for now in said], heights, color=style.ORANGE, label="along, across")
        spread.plot([now.sigma_up for now in said], heights, color=style.GREEN, label="upwards")
    met = flight.wind
    edges = np.linspace(0.0, float(np.max(state.height)) + 1.0, LAYERS + 1)
    layer = np.digitize(state.height, edges)
    for number in np.unique(layer):
        among = layer == number
        if among.sum() < LEAST:
            continue
        height = float(state.height[among].mean())
        north, east = met[0, among].mean(), met[1, among].mean()
        speed.plot(math.hypot(north, east), height, "o", color=style.BLUE, markersize=3.5)
        if table.intensity > 0.0:
            level = math.sqrt(float(np.mean(gusts[:2, among] ** 2)))
            spread.plot(level, height, "o", color=style.ORANGE, markersize=3.5)
            rising = math.sqrt(float(np.mean(gusts[2, among] ** 2)))
            spread.plot(rising, height, "o", color=style.GREEN, markersize=3.5)
    speed.set_xlim(left=0.0)
    speed.set_ylim(0.0, top)
    spread.set_xlim(left=0.0)
    speed.set_ylabel("height, m")
    speed.set_xlabel("wind speed, m/s")
    spread.set_xlabel("standard deviation of the turbulence, m/s")
    for axes in (speed, spread):
        axes.legend(loc="upper left") if axes.get_legend_handles_labels()[0] else None
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


def spectra(flight: Flight, scenario: Any, gusts: np.ndarray) -> Any | None:
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
        panel.loglog(frequency[shown], density[shown], color=style.SKY, linewidth=0.8)
        panel.loglog(frequency[shown], form(frequency[shown], airspeed, sigma, length), color=style.BLACK)
        panel.set_title(name)
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_formatter("{x:g}")
    axes[0].set_ylabel("density, (m/s)\u00b2 / (rad/s)")
    axes[1].set_xlabel("circular frequency, rad/s")
    return figure


def spectrum(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(circular frequency, one-sided density): the mean over windows that overlap by half, each under a cosine."""
    taper = np.hanning(WINDOW)
    starts = range(0, len(values) - WINDOW + 1, WINDOW // 2)
    power = np.mean([np.abs(np.fft.rfft(taper * values[a : a + WINDOW])) ** 2 for a in starts], axis=0)
    return 2.0 * np.pi * np.fft.rfftfreq(WINDOW, RECORD_STEP), power * RECORD_STEP / (np.pi * np.sum(taper**2))


def section_through(flight: Flight, scenario: Any, event: WindEvent) -> Any:
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
    axes.grid(False)
    along, heights = np.linspace(middle - reach, middle + reach, 81), np.linspace(0.0, top, 41)
    tail, _ = section(along, heights)
    most = max(float(np.abs(tail).max()), 1.0)
    levels = np.linspace(-most, most, 17)
    shades = axes.contourf(along, heights, np.clip(tail, -most, most), levels, cmap="RdBu_r", alpha=0.6)
    figure.colorbar(shades, ax=axes, label="tailwind, m/s", pad=0.02)
    x, z = np.linspace(middle - reach, middle + reach, ARROWS[0]), np.linspace(0.04, 0.96, ARROWS[1]) * top
    axes.quiver(x, z, *section(x, z), color="#444444", width=0.0016, scale=22.0 * most)
    by_phase(axes, flight, past, state.height, near)
    axes.set_xlim(middle - reach, middle + reach)
    axes.set_ylim(0.0, top)
    axes.set_xlabel("distance past the threshold, m")
    axes.set_ylabel("height, m")
    return figure

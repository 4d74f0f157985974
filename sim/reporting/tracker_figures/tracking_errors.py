"""Errors of the trackers over time: how large, against their own covariances, by phase, against the radar's norm."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.observation.antenna import inside
from sim.reporting.drawing.figure import Drawing, Panel
from sim.reporting.drawing.marks import PAPER, Points
from sim.reporting.drawing.scales import LOGARITHMIC, Scale, written
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from sim.reporting.figures.thinning import peaks
from sim.reporting.text.labels import split, words
from sim.reporting.tracker_figures.error_curves import Shown, shown_channels
from sim.reporting.tracker_figures.path_bound import PathBound

BINS = 160  # stretches of a curve whose least and greatest value are drawn
COLUMNS = 3  # of the small panels
CREDIBLE = 30.0  # times the median 2 sigma of all: the frame of the small panels, linear up to once that
UNCREDIBLE = 1e3  # ANEES and NIS of lost trackers may leave the frame
DECADES = 4.0  # most that a logarithmic axis shows


def error_over_time(flight: Flight, followed: list[Shown], bound: PathBound | None) -> Drawing:
    """Figure of the RMSE over draws at every epoch, one panel for each channel, on logarithmic axes."""
    names = shown_channels(followed)[:3]
    figure, (strip, *panels) = style.panels(STRIP, *(1.9 for _ in names))
    phase_strip(strip, flight)
    for axes, channel in zip(panels, names, strict=True):
        shown = [one for one in followed if channel in one.curves.channels]
        _raw(axes, shown, channel)
        for one in shown:
            curves = one.curves
            thinned(axes, curves.time, curves.channels[channel].rmse, label=words(one.name), width=1.0, **one.look)
        if bound is not None and channel in ("position_m", "cross_track_m"):
            limit = bound.position if channel == "position_m" else bound.cross_track
            thinned(
                axes, bound.time, limit, colour=style.BLACK, width=1.2, dashes=(1, 1.2), label="known accelerations"
            )
        logarithmic(axes)
        axes.y.label = _label(channel, "RMSE")
    panels[-1].x.label = TIME
    legend(figure, panels[0], followed)
    return figure


def _raw(axes: Panel, shown: list[Shown], channel: str) -> None:
    """The raw measurements, from the tracker that has most of them."""
    most = max((one.curves for one in shown), key=lambda curves: np.isfinite(curves.channels[channel].raw).sum())
    raw = most.channels[channel].raw
    chosen = np.flatnonzero(np.isfinite(raw))
    if chosen.size:
        chosen = chosen[peaks(raw[chosen], BINS)]
        axes.points(most.time[chosen], raw[chosen], colour="#B0B0B0", size=2.0, label="raw measurement", order=1.2)


def credibility(flight: Flight, followed: list[Shown]) -> Drawing | None:
    """Figure with a panel for each tracker: 95 % of its signed errors against +-2 sigma of its own covariance."""
    channel = next((c for c in ("cross_track_m", *shown_channels(followed)) if c != "position_m"), "")
    shown = [one for one in followed if channel in one.curves.channels]
    if not shown:
        return None
    twice = np.concatenate([2 * one.curves.channels[channel].sigma for one in shown])
    scale = float(np.nanmedian(twice)) if np.isfinite(twice).any() else 1.0
    rows = -(-len(shown) // COLUMNS)
    figure, grid = style.grid(rows, min(COLUMNS, len(shown)), 0.95)
    for axes, one in zip(grid, shown, strict=False):
        curves = one.curves.channels[channel]
        colour = one.look["colour"]
        chosen = np.union1d(*(peaks(curve, BINS // 2) for curve in (curves.low, curves.high)))
        time, sigma = one.curves.time[chosen], curves.sigma[chosen]
        axes.band(time, -2 * sigma, 2 * sigma, style.SHADE, label="±2 σ that it states")
        for side, curve in enumerate((curves.low, curves.high)):
            label = "" if side else "2.5 and 97.5 % of its errors" if one.curves.draws > 1 else "its error"
            axes.line(time, curve[chosen], colour=colour, width=0.8, label=label)
        axes.rule(y=0.0, width=0.4)
        axes.title, axes.title_size = words(one.name), 7.5
    style.end_columns(figure, len(shown), COLUMNS)
    scale = 10.0 ** round(float(np.log10(scale)))
    x, y = grid[0].x, grid[0].y
    y.scale, y.limits = Scale("symmetric", scale, 1.33), (-CREDIBLE * scale, CREDIBLE * scale)
    ticks = [0.0, *(side * size * scale for side in (-1, 1) for size in (1, 10))]
    y.ticks = [(tick, written(tick)) for tick in sorted(ticks)]
    x.limits = float(flight.time[0]), float(flight.time[-1]) + 1e-6
    y.label, y.label_size = _label(channel, ""), 7.0
    x.label = TIME
    figure.legend = [grid[0].labelled]
    return figure


def consistency_over_time(flight: Flight, followed: list[Shown]) -> Drawing:
    """Figure of ANEES and of the mean NIS at every epoch with the band that 95 % of consistent trackers keep."""
    figure, (strip, errors, innovations) = style.panels(STRIP, 1.7, 1.7)
    phase_strip(strip, flight)
    channel = shown_channels(followed)[0]
    dimension = 2 if channel == "position_m" else 1
    for one in followed:
        look = {"label": words(one.name), "width": 0.9, **one.look}
        if channel in one.curves.channels:
            thinned(errors, one.curves.time, one.curves.channels[channel].anees, **look)
        thinned(innovations, one.curves.time, one.curves.nis, **look)
    most = max((one.curves for one in followed), key=lambda curves: len(curves.time))
    seen = most.nis_samples > 0
    time = np.array((flight.time[0], flight.time[-1]))
    for axes, samples, when in (
        (errors, np.full(2, float(max(one.curves.draws for one in followed) * dimension)), time),
        (innovations, most.nis_samples[seen].astype(float), most.time[seen]),
    ):
        band_of_one(axes, samples, when)
    errors.y.label = f"ANEES of {split(channel)[0]}"
    innovations.y.label = "mean NIS"
    innovations.x.label = TIME
    legend(figure, errors, followed)
    return figure


def band_of_one(axes: Panel, samples: np.ndarray, when: np.ndarray) -> None:
    """The band about 1 in which means of so many squares lie with 95 %, on a logarithmic axis."""
    from scipy.special import chdtri

    chosen = peaks(samples, BINS // 2)
    low, high = (chdtri(samples[chosen], tail) / samples[chosen] for tail in (0.975, 0.025))
    axes.band(when[chosen], low, high, "#BBBBBB", order=1.1, label="95 % band")
    axes.rule(y=1.0, order=1.3)
    logarithmic(axes)
    axes.y.limits = 0.2, min(max(axes.y.limits[1] or 0.0, 5.0), UNCREDIBLE)


def error_by_phase(flight: Flight, trackers: dict[str, Any], followed: list[Shown]) -> Drawing | None:
    """Figure of the RMSE by phase as bars, with intervals and the raw measurement across each group."""
    looks = {one.name: one.look for one in followed}
    names = [c for c in shown_channels(followed) if any(c in by for t in trackers.values() for by in _phases(t))][:2]
    if not names:
        return None
    figure, panels = style.panels(*(1.6 for _ in names))
    order = list(dict.fromkeys(flight.phases[int(i)] for i in flight.phase))
    for axes, channel in zip(panels, names, strict=True):
        flown = [p for p in order if any(channel in (t.get("by_phase") or {}).get(p, {}) for t in trackers.values())]
        width, sizes = 0.84 / len(looks), []
        for row, (name, look) in enumerate(looks.items()):
            by_phase = [(trackers[name].get("by_phase") or {}).get(phase, {}).get(channel) or {} for phase in flown]
            at = np.arange(len(flown)) - 0.42 + (row + 0.5) * width
            top, low, high = (_numbers([figures.get(key) for figures in by_phase]) for key in ("rmse", "low", "high"))
            _bars(axes, at, top, 0.43 * width, look)
            nothing = np.full(len(at), np.nan)
            ends = np.stack((low, high, nothing), axis=1).ravel()
            axes.line(np.stack((at, at, nothing), axis=1).ravel(), ends, colour="#333333", width=0.6)
            sizes += top[np.isfinite(top)].tolist()
        for place, phase in enumerate(flown):
            raws = [(t.get("by_phase") or {}).get(phase, {}).get(channel, {}).get("raw") for t in trackers.values()]
            raw = next((value for value in raws if value), None)
            if raw:
                label = "" if any(mark.label for mark in axes.marks) else "raw measurement"
                axes.line((place - 0.45, place + 0.45), (raw, raw), label=label)
                sizes.append(raw)
        axes.x.ticks = [(float(place), words(phase)) for place, phase in enumerate(flown)]
        axes.grid = "y"
        axes.y.label = _label(channel, "RMSE")
        logarithmic(axes, *sizes)
        highest = axes.y.limits[1] or 1.0
        axes.y.limits = max(0.6 * min(sizes), highest / 10**DECADES), highest
        axes.x.limits = -0.55, len(flown) - 0.45
    legend(figure, panels[0], followed)
    return figure


def _numbers(values: list[Any]) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in values], float)


def _bars(axes: Panel, at: np.ndarray, tops: np.ndarray, half: float, look: dict[str, Any]) -> None:
    """Bars of one tracker; hatched where its law is mismatched."""
    colour = look["colour"]
    inside, hatch = (PAPER, colour) if look["dashes"] in style.DASHES else (colour, "")
    axes.blocks(at - half, at + half, 0.0, tops, inside, edge=colour, hatch=hatch)


def _phases(tracker: dict[str, Any]) -> list[dict[str, Any]]:
    return list((tracker.get("by_phase") or {}).values())


def containment(flight: Flight, scenario: Any, followed: list[Shown]) -> tuple[Drawing, str] | None:
    """Figure of the 95th percentile of the cross-track error against the azimuth norm of a precision radar.

    Also a sentence on how often each tracker keeps it; None without such a radar or without a place.
    """
    precise = (it for it in scenario.sensors.values() if {"range", "azimuth", "elevation"} <= {*it.channels})
    radar = next((it for it in precise if it.outline()), None)
    shown = [one for one in followed if "cross_track_m" in one.curves.channels]
    if radar is None or not shown:
        return None
    from sim.flight.interpolation import truth_at

    figure, (strip, axes) = style.panels(STRIP, 2.1)
    phase_strip(strip, flight)
    shares, covered = [], radar.outline()
    seen = inside(covered, flight.state.north, flight.state.east)
    if not seen.any():
        return None
    norm = np.where(seen, azimuth_norm(_slant(radar, flight.state)), np.nan)
    chosen = peaks(norm, BINS)
    axes.band(flight.time[chosen], 1e-3, norm[chosen], style.SHADE, label="within the norm")
    axes.line(flight.time[chosen], norm[chosen], colour=style.BLACK, width=1.2, label="norm")
    for one in shown:
        state = truth_at(flight, one.curves.time).state
        within = inside(covered, state.north, state.east)
        p95 = np.where(within, one.curves.channels["cross_track_m"].p95, np.nan)
        thinned(axes, one.curves.time, p95, label=words(one.name), width=1.0, **one.look)
        if within.any():
            kept = float(np.mean(p95[within] <= azimuth_norm(_slant(radar, state)[within])))
            shares.append((kept, f"{words(one.name)} {100 * kept:.0f} %"))
    logarithmic(axes)
    first, last = flight.time[np.flatnonzero(seen)[[0, -1]]]
    axes.x.limits = float(first), max(float(last), float(first) + 1e-6)
    axes.y.label = "95 % of |cross-track|, m"
    axes.x.label = TIME
    legend(figure, axes, followed)
    shares.sort(key=lambda share: -share[0])
    return figure, "; ".join(text for _, text in shares)


def _slant(radar: Any, state: Any) -> np.ndarray:
    return np.asarray(radar.truth(state)[radar.channels.index("range")])


def azimuth_norm(distance: Any) -> Any:
    """Largest azimuth error (m) at a distance (m) from the antenna: 0.6 % of it, 9 m at least."""
    return np.maximum(0.006 * distance, 9.0)


def look_ahead_fan(trackers: dict[str, Any], followed: list[Shown]) -> Drawing | None:
    """Figure of the RMSE of predicted positions over how far ahead they were made; None where none were."""
    looks = {one.name: one.look for one in followed}
    chosen = {name: t["look_ahead"] for name, t in trackers.items() if name in looks and t.get("look_ahead")}
    found = dict.fromkeys(channel for by in chosen.values() for figures in by.values() for channel in figures)
    names = [channel for channel in ("position_m", "cross_track_m") if channel in found]
    if not names:
        return None
    figure, panels = style.panels(*(1.7 for _ in names))
    for axes, channel in zip(panels, names, strict=True):
        for name, by in chosen.items():
            points = sorted(
                (float(span.partition("_")[0]), _rmse(figures.get(channel))) for span, figures in by.items()
            )
            ahead, errors = np.array([point for point in points if point[1] is not None]).reshape(-1, 2).T
            axes.line(ahead, errors, label=words(name), **looks[name])
            axes.points(ahead, errors, colour=looks[name]["colour"], marker="o")
        logarithmic(axes)
        axes.y.label = _label(channel, "RMSE")
    panels[-1].x.label = "looked ahead, s"
    legend(figure, panels[0], followed)
    return figure


def _rmse(figure: Any) -> float | None:
    return figure.get("rmse") if isinstance(figure, dict) else figure


# ------------------------------------------------------------------------------------------------ shared by the above


def thinned(axes: Panel, time: np.ndarray, values: np.ndarray, **look: Any) -> None:
    """Draw a curve with the peaks of its finite values; where it is missing it is broken."""
    chosen = peaks(values, BINS)
    axes.line(time[chosen], values[chosen], **look)


def logarithmic(axes: Panel, *more: float) -> None:
    """A logarithmic axis of few labelled ticks, at most some decades below its greatest value or one of ``more``."""
    values = [line.y for line in axes.lines if len(line.y) > 2]
    values += [mark.y for mark in axes.marks if isinstance(mark, Points)] + [np.array(more, float)]
    every = np.concatenate(values)
    every = every[np.isfinite(every) & (every > 0.0)]
    low, high = (float(every.min()), float(every.max())) if every.size else (0.1, 10.0)
    low, high = max(low, high / 10**DECADES), max(high, low * 3)
    axes.y.scale, axes.y.limits = LOGARITHMIC, (low / 1.3, high * 1.3)


def legend(figure: Drawing, axes: Panel, followed: list[Shown]) -> None:
    """A legend above the panels of all but the trackers, whose colours the page names beside each figure."""
    names = {words(one.name) for one in followed}
    figure.legend = [[mark for mark in axes.labelled if mark.label not in names]]


def _label(channel: str, what: str) -> str:
    name, unit = split(channel)
    return f"{name} {what}".strip() + f", {unit}"

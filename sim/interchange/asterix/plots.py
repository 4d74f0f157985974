"""read_plots(): target reports of a radar (CAT048) or of ADS-B (CAT021) as recorded plots of one aircraft."""

from __future__ import annotations

from itertools import islice

import numpy as np

from sim.interchange.asterix.blocks import AsterixError
from sim.interchange.asterix.reading import Feed, feed_of, first_of, without_midnights
from sim.interchange.clocks import Stamps
from sim.interchange.plots import Plots

ADSB, SERVICE, RADAR = 21, 34, 48
PLACE = ("range", "azimuth", "latitude", "longitude")
HEIGHTS = ("pressure_altitude", "sea_level_height")
# category -> what of a report is where: the first of these fields that it has
FIELDS: dict[int, dict[str, tuple[str, ...]]] = {
    RADAR: {
        "sac": ("010.sac",), "sic": ("010.sic",), "time": ("140.time",),
        "range": ("040.rho",), "azimuth": ("040.theta",),
        "pressure_altitude": ("090.level",), "unvalidated": ("090.v",), "garbled": ("090.g",),
        "sea_level_height": ("110.height",),
        "address": ("220.address",), "number": ("161.number",), "code": ("070.code",),
        "report": ("020.typ",), "monitor": ("020.rab",), "test": ("020.tst",),
    },
    ADSB: {
        "sac": ("010.sac",), "sic": ("010.sic",), "time": ("071.time", "073.time", "077.time"),
        "latitude": ("131.latitude", "130.latitude"), "longitude": ("131.longitude", "130.longitude"),
        "pressure_altitude": ("145.level",),
        "address": ("080.address",), "number": ("161.number",), "code": ("070.code",),
        "monitor": ("040.rab",), "test": ("040.tst",),
    },
}  # fmt: skip
NAMES = dict.fromkeys(name for fields in FIELDS.values() for name in fields)
SHOWN = 12  # names in a sentence
IDENTITIES = {"address": "06x", "number": "d", "code": "04o"}  # how each is written, the first is looked for first
Values = dict[str, np.ndarray]


def read_plots(content: bytes, target: str | None = None, source: str | None = None) -> Plots:
    """The plots of one aircraft, seen by one radar or receiver.

    Parameters
    ----------
    target : which aircraft, where the file has several: its address (six hexadecimal digits), else its track number,
        else its Mode 3/A code, by the first of these that the file has
    source : which radar or receiver, where the file has several: ``"SAC/SIC"``

    Raises ``AsterixError`` in one sentence for what cannot be read, and where a choice is left open.
    """
    feed = feed_of(content, (RADAR, ADSB))
    chosen, values = _of_source(_reports(feed), source)
    values, remarks = _usable(values)
    values = _of_target(values, target)
    time = without_midnights(values["time"])
    order = np.argsort(time, kind="stable")
    time = time[order]
    same = np.flatnonzero(np.diff(time) == 0.0)
    if same.size:
        raise AsterixError(
            f"has two plots at {time[same[0]]:.3f} s of the day, and nothing says which is that of the aircraft"
        )
    known = {name: values[name][order] if np.isfinite(values[name]).any() else None for name in (*PLACE, *HEIGHTS)}
    nothing = dict.fromkeys(("height", "range_sigma", "azimuth_sigma", "height_sigma", "position_sigma"))
    told = (*feed.remarks, *remarks)
    return Plots(Stamps(False, time), **known, **nothing, remarks=told, antenna=_antenna(feed, chosen))


def _reports(feed: Feed) -> Values:
    """All reports, those of radars first; SI, NaN = not there."""
    parts = []
    for number, fields in FIELDS.items():
        if number in feed.categories:
            records = feed.records(number)
            parts.append({name: first_of(records, fields.get(name, ())) for name in NAMES})
    return {name: np.concatenate([part[name] for part in parts]) for name in NAMES}


def _some(values: Values, which: np.ndarray) -> Values:
    return {name: column[which] for name, column in values.items()}


def _of_source(values: Values, source: str | None) -> tuple[str, Values]:
    """The reports of one radar or receiver, and what it is called."""
    code = np.where(np.isfinite(values["sac"]), 256.0 * values["sac"] + values["sic"], -1.0).astype(int)
    names = {int(one): f"{one >> 8}/{one & 255}" for one in np.unique(code[code >= 0])}
    listed = ", ".join(islice(names.values(), SHOWN))
    if source is not None and source not in names.values():
        raise AsterixError(f"has no plots of the source '{source}'; it has {listed or 'none with a name'}")
    if source is None and len(names) > 1:
        raise AsterixError(f'has plots of several radars or receivers, {listed}; say source = "{names[min(names)]}"')
    wanted = {name: one for one, name in names.items()}.get(source or "", min(names, default=-1))
    values = _some(values, code == wanted)
    radar = np.isfinite(values["range"])
    return names.get(wanted, ""), _some(values, radar) if radar.any() else values


def _usable(values: Values) -> tuple[Values, list[str]]:
    """The reports that are plots of aircraft, and what was left out; heights that are in doubt become unknown."""
    told = []

    def without(which: np.ndarray, what: str) -> None:
        nonlocal values
        if which.any():
            told.append(f"{int(which.sum())} {what} are left out")
        values = _some(values, ~which)

    without(values["report"] == 0.0, "reports without a detection (predicted, I048/020)")
    without((values["monitor"] == 1.0) | (values["test"] == 1.0), "reports of field monitors and test targets")
    placed = np.isfinite(values["range"] + values["azimuth"]) | np.isfinite(values["latitude"] + values["longitude"])
    without(~placed, "reports without a place")
    without(~np.isfinite(values["time"]), "reports without a time of day")
    doubtful = ((values["unvalidated"] == 1.0) | (values["garbled"] == 1.0)) & np.isfinite(values["pressure_altitude"])
    if doubtful.any():
        told.append(f"{int(doubtful.sum())} Mode C heights that are garbled or not validated are taken for unknown")
    if not len(values["time"]):
        raise AsterixError(f"has no plots: {told[0]}" if told else "has no plots")
    return {**values, "pressure_altitude": np.where(doubtful, np.nan, values["pressure_altitude"])}, told


def _of_target(values: Values, target: str | None) -> Values:
    """The reports of one aircraft."""
    for name, form in IDENTITIES.items():
        column = values[name]
        known = np.unique(column[np.isfinite(column)]).astype(int)
        if not known.size:
            continue
        listed = {format(int(one), form): int(one) for one in known}
        if target is None and len(known) > 1:
            raise AsterixError(f'has plots of {len(known)} aircraft; say target = "{next(iter(listed))}", or another')
        if target is None:
            return values
        if target.lower() not in listed:
            some = ", ".join(islice(listed, SHOWN)) + (", ..." if len(listed) > SHOWN else "")
            raise AsterixError(f"has no plots of the target '{target}'; it has {some}")
        return _some(values, column == listed[target.lower()])
    if target is not None:
        raise AsterixError(f"does not say whose plots it has, so there is no target '{target}'")
    return values


def _antenna(feed: Feed, source: str) -> tuple[float, float, float] | None:
    """(latitude rad, longitude rad, height m above the sea) of a radar, where its service messages say it."""
    if SERVICE not in feed.categories:
        return None
    records = feed.records(SERVICE)
    columns = [
        first_of(records, (name,)) for name in ("010.sac", "010.sic", "120.latitude", "120.longitude", "120.height")
    ]
    own = [row for row in zip(*columns, strict=True) if f"{row[0]:.0f}/{row[1]:.0f}" == source and np.isfinite(row[2])]
    return (float(own[0][2]), float(own[0][3]), float(own[0][4])) if own else None

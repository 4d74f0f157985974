"""What a run says of the trackers that it contrasts: how far apart they are, ahead and over the flight, and why."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from sim.reporting.text import reasons
from sim.reporting.text.best_tracker import MOST_LOST
from sim.reporting.text.labels import joined, number, split, words
from sim.reporting.text.reasons import Apart, Flown, Loss
from sim.reporting.tracker_figures.error_curves import FIRST

SPAN = "60_s"  # of the look-ahead that is told, where the contrast has it
OFF = {"position_m": "off by", "cross_track_m": "off across track by", "height_m": "off in height by"}

ERRORS, INTERVALS = "Errors are root mean squares", ", intervals of 95 %"

Contrast = dict[str, Any]  # as in metrics.json
Ratio = dict[str, Any]  # of one channel: ratio, low, high, n, of, against


def contrast_sentences(metrics: dict[str, Any], flown: Flown, figures: dict[str, Any] | None = None) -> list[str]:
    """What is said of each pair of trackers that a run contrasts, over all its flights; empty where it contrasts none.

    Each entry is a line of its own: how far apart they are when they look ahead, how far over the flight, and who is
    lost. Contrasts of the same two kinds of trackers are different ways to set them up, and told together.

    Parameters
    ----------
    metrics : as in metrics.json
    flown : the flight that shows why
    figures : of its trackers, as in metrics.json; None = those of ``metrics``, which is about this flight alone
    """
    figures = metrics["trackers"] if figures is None else figures
    lost = {
        name: found
        for contrast in metrics.get("contrasts", ())
        for name in (contrast["of"], contrast["against"])
        if (found := reasons.loss(flown, name, figures.get(name, {}).get("lost_time_s"))) is not None
    }
    first = first_contrast(metrics)
    told: list[str] = []
    for ways in _ways(metrics).values():
        leading = _closest(ways)
        parted = None if leading is None else reasons.apart(flown, leading["of"], leading["against"])
        told += lines(metrics, ways, lost, parted if leading is first else None)
    return told


def losses(metrics: dict[str, Any], flown: Flown, figures: dict[str, Any]) -> list[str]:
    """Of each tracker that loses more draws than a good one may: when it is lost on a flight, and why.

    ``figures`` are those of the trackers on this flight; the others as for `contrast_sentences`.
    """
    shares = {name: t.get("lost_fraction") or 0.0 for name, t in metrics.get("trackers", {}).items()}
    return [
        _capital(_loss(metrics, name, share, reasons.loss(flown, name, figures.get(name, {}).get("lost_time_s"))))
        for name, share in shares.items()
        if share > MOST_LOST
    ]


def first_contrast(metrics: dict[str, Any]) -> Contrast | None:
    """The contrast that the first figure and the replay show: of the first pair, the way in which they differ least.

    None where nothing is contrasted, or one of the two never tracked.
    """
    for ways in _ways(metrics).values():
        return _closest(ways)
    return None


def _ways(metrics: dict[str, Any]) -> dict[tuple[str, str], list[Contrast]]:
    """The contrasts by the kinds of their two trackers, in the order of the file."""
    found: dict[tuple[str, str], list[Contrast]] = {}
    for contrast in metrics.get("contrasts", ()):
        of, against = (metrics["trackers"].get(contrast[side], {}).get("kind") for side in ("of", "against"))
        found.setdefault((of or contrast["of"], against or contrast["against"]), []).append(contrast)
    return found


def _closest(ways: Sequence[Contrast]) -> Contrast | None:
    known = [(abs(math.log(entry["ratio"])), way) for way in ways if (entry := _overall(way)[1]) is not None]
    return min(known, key=lambda pair: pair[0])[1] if known else None


def lines(
    metrics: dict[str, Any], ways: Sequence[Contrast], lost: dict[str, Loss], parted: Apart | None = None
) -> list[str]:
    """What is said of one pair of kinds of trackers, which may be set up in several ways.

    Ways without a ratio are left out: the warnings of the run say of each why it has none.
    """
    names = _names(metrics, ways)
    able = [way for way in ways if _overall(way)[1] is not None]
    over = f"over {metrics['flights']} flights" if metrics.get("flights", 1) > 1 else ""
    told = [
        _measured(f"{span.removesuffix('_s')} s ahead{', ' + over + ',' if over else ''}", able, names, ahead)
        for span in _spans(able)
        if (ahead := _reader(span)) is not None
    ]
    if able:
        told.append(_measured(f"{over or 'over the whole flight'}", able, names, _overall))
        known = [entry["low"] for way in able if (entry := _overall(way)[1]) is not None]
        explained = f"{ERRORS}{INTERVALS if any(map(_known, known)) else ''}."
        told.append(" ".join(map(_capital, (*_who_is_lost(metrics, able, lost, parted), explained))))
    return [_capital(line) for line in told if line]


def _capital(sentence: str) -> str:
    return sentence[0].upper() + sentence[1:]


def _names(metrics: dict[str, Any], ways: Sequence[Contrast]) -> Callable[[Contrast, str], str]:
    """How a tracker of a contrast is called: by its kind where several ways are told, which then name themselves."""
    kinds = {side: metrics["trackers"].get(ways[0][side], {}).get("kind") for side in ("of", "against")}
    apart = None not in kinds.values() and kinds["of"] != kinds["against"]
    if apart and len(ways) > 1 and all(way.get("name") for way in ways):
        return lambda way, side: words(kinds[side])
    return lambda way, side: words(way[side])


def _spans(ways: Sequence[Contrast]) -> list[str]:
    """The one span of the look-ahead that is told: 60 s, else the longest; none where nothing was predicted."""
    known = [span for way in ways for span, channels in way["look_ahead"].items() if _chosen(channels)[1] is not None]
    if not known or SPAN in known:
        return [SPAN] if known else []
    return [max(known, key=lambda span: float(span.removesuffix("_s")))]


def _reader(span: str) -> Callable[[Contrast], tuple[str, Ratio | None]]:
    return lambda way: _chosen(way["look_ahead"].get(span, {}))


def _overall(way: Contrast) -> tuple[str, Ratio | None]:
    return _chosen(way["overall"])


def _chosen(channels: dict[str, Ratio]) -> tuple[str, Ratio | None]:
    """(channel, ratio) of the place where both know it; None for the ratio where they have nothing in common."""
    for channel in (*FIRST, *channels):
        entry = channels.get(channel)
        if entry is not None and _known(entry["ratio"]) and entry["ratio"] > 0.0:
            return channel, entry
    return "", None


def _known(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def _measured(
    where: str,
    ways: Sequence[Contrast],
    names: Callable[[Contrast, str], str],
    read: Callable[[Contrast], tuple[str, Ratio | None]],
) -> str:
    """One sentence with the ratio of every way: the better one's error, the worse one's, how many times it is."""
    parts: list[str] = []
    before = None
    for way in ways:
        channel, entry = read(way)
        if entry is None:
            continue
        told = _told(entry)
        better, worse = (names(way, side) for side in told.order)
        small, large = (_size(entry[side], split(channel)[1]) for side in told.order)
        off = OFF.get(channel, f"off in {split(channel)[0]} by")
        named = f"{way['name']}, " if len(ways) > 1 and way.get("name") else ""
        if (better, worse, off) == before:
            parts.append(f"{named}by {small} and {large}, {told.times}")
        else:
            parts.append(f"{named}{better} is {off} {small} and {worse} by {large}, {told.times}")
        before = better, worse, off
    if not parts:
        return ""
    comma = "," if len(ways) > 1 and not where.endswith(",") else ""
    return f"{where}{comma} {'; '.join(parts)}."


def _size(value: float, unit: str) -> str:
    """An error to three figures."""
    places = 0 if value >= 100.0 else 1 if value >= 10.0 else 2 if value >= 1.0 else 3
    return f"{number(float(value), places)} {unit}"


class _Told(NamedTuple):
    """A ratio of two errors with the better one first."""

    order: tuple[str, str]  # sides of the contrast: better, worse
    times: str  # in words


def _told(entry: Ratio) -> _Told:
    """How many times the worse errs, with its interval, or that the noise hides it."""
    ratio, low, high = entry["ratio"], entry["low"], entry["high"]
    order = ("against", "of")
    if ratio < 1.0:
        order = ("of", "against")
        ratio, low, high = 1.0 / ratio, high and 1.0 / high, low and 1.0 / low
    places = 0 if ratio >= 20.0 else 1 if ratio >= 2.0 else 2
    if _known(low) and _known(high) and high - low < 2.0 * 10.0**-places:  # else the interval would look like a point
        places += 1
    times = f"{number(float(ratio), places)} times"
    if ratio == low == high == 1.0:
        return _Told(order, "exactly the same")
    if not (_known(low) and _known(high)):
        return _Told(order, f"{times} as much, which a single sample does not tell from chance")
    interval = f"{number(float(low), places)} to {number(float(high), places)}"
    if low <= 1.0 <= high:
        return _Told(order, f"no difference within the noise ({times}, {interval})")
    return _Told(order, f"{times} as much ({interval})")


def _who_is_lost(
    metrics: dict[str, Any], ways: Sequence[Contrast], lost: dict[str, Loss], parted: Apart | None
) -> list[str]:
    """Who is lost, when and why; where nobody is, where they part and why."""
    trackers = list(dict.fromkeys(way[side] for way in ways for side in ("of", "against")))
    shares = {name: metrics["trackers"].get(name, {}).get("lost_fraction") or 0.0 for name in trackers}
    told = [_loss(metrics, name, share, lost.get(name)) for name, share in shares.items() if share > 0.0]
    spared = [words(name) for name, share in shares.items() if share == 0.0]
    if not told:
        told = ["Neither is ever lost." if len(spared) == 2 else "None of them is ever lost."]
        if parted is not None:
            told.append(f"They part at {parted.stretch.start:.0f} s ({parted.phase}): {parted.cause}.")
    elif spared:
        told.append(f"{joined(spared)} {'is' if len(spared) == 1 else 'are'} never lost.")
    return told


def _loss(metrics: dict[str, Any], name: str, share: float, found: Loss | None) -> str:
    several = metrics.get("flights", 1) > 1
    only = not several and metrics.get("draws", 1) == 1
    draws = f"in {number(100.0 * share, 0 if share > 0.1 else 1)} % of the draws"
    if share == 1.0:
        draws = "" if only else "in every draw"
    of_all = f" of all {metrics['flights']} flights" if several else ""
    here = "on this flight first at" if several else "at" if only else "first at"
    if found is None:
        return f"{words(name)} is lost {draws}{of_all}{', not on this flight' if several else ''}."
    when = f"{here} {found.time:.0f} s, astray since {found.astray:.0f} s ({found.phase}): {found.cause}"
    return f"{words(name)} is lost {draws}{of_all}{', ' if draws else ''}{when}."

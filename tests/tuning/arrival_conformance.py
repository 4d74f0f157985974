"""The conformance alert on arrivals that look like recorded ones: ``python -m tests.tuning.arrival_conformance``.

False alarms are counted on windows of 200 s of established flight, each with a track of its own, and on whole vectored
arrivals; delays on aircraft that leave the law. Both over the rates that the test can be set to: its operating curve.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.metrics.alarms.detection import detection, onsets
from tests.tuning.arrival_trackers import ASSUMED, RADARS, TRACKERS, Factory, Scene, arrival, watched
from tests.tuning.arrivals import by_heading, by_law
from tests.tuning.look_alikes import look_alikes
from tracking.conformance import CONFORMANCE, ConformanceTest
from tracking.gaussian import Gaussian
from tracking.track import track

WINDOW = 200.0  # s, of established flight
LEAD, BEHIND = 80.0, 150.0  # s before and behind a departure
RATES = (30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 1e6, 1e8)  # looks between false alarms, as the test is told
ASKED = 1000.0  # looks between false alarms, at which delays are compared
DEPARTURES = {"law": by_law.DEPARTURES, "heading": by_heading.DEPARTURES}


class Conformance(NamedTuple):
    """What the alert does at each of the r rates."""

    rates: Any  # (r,) looks between false alarms that it is told; the last is the default
    false: Any  # (r,) false alarms in 1000 looks of established windows
    windows: Any  # (r,) share of the established windows with an alarm
    arrivals: Any  # (r,) share of whole arrivals with an alarm
    delays: dict[str, Any]  # (r,) s, median by departure; infinite = half of them are missed

    @property
    def asked(self) -> int:
        """The first rate whose false alarms are as rare as is asked; the last but one where none is."""
        good = np.flatnonzero(self.false[:-1] <= 1000.0 / ASKED)
        return int(good[0]) if len(good) else len(self.rates) - 2


def established(flight: Flight) -> tuple[float, float]:
    """The first 200 s behind the capture."""
    _, last = arrival(flight)
    behind = flight.time[flight.during("capture")][-1]
    return float(behind), min(float(behind) + WINDOW, last)


def departed(flight: Flight) -> tuple[float, float]:
    """About the instant at which the law is left."""
    (left,) = (event.time for event in flight.events if event.name == "departed")
    return left - LEAD, left + BEHIND


def conformance(kind: str, seed: int, count: int, draws: int, factory: Factory, law: Any = ASSUMED) -> Conformance:
    """The alert by one tracker on the look-alikes of a generator."""
    flights, radar = look_alikes(kind, seed, count), RADARS[kind]
    long = [flight for flight in flights if np.diff(established(flight)) >= WINDOW - 1.0]
    on_law = _alarms(watched(long, radar, seed, draws, established), factory, law)
    whole = _alarms(watched(flights, radar, seed, draws), factory, law)
    delays = {}
    for departure in DEPARTURES[kind]:
        leaving = [one for one in look_alikes(kind, seed, count, departure) if len(one.events) > 1]
        leaving = [one for one in leaving if departed(one)[0] >= one.time[0] and departed(one)[1] <= one.time[-1]]
        seen = watched(leaving, radar, seed, draws, departed)
        time = np.asarray(seen.plots.time)
        delays[departure] = np.array([detection(one, time, LEAD).median_delay for one in _alarms(seen, factory, law)])
    looks = on_law[0].size
    return Conformance(
        np.array((*RATES, CONFORMANCE.looks_between_false_alarms)),
        np.array([1000.0 * onsets(one).sum() / looks for one in on_law]),
        np.array([one.any(axis=0).mean() for one in on_law]),
        np.array([one.any(axis=0).mean() for one in whole]),
        delays,
    )


def _alarms(seen: Scene, factory: Factory, law: Any) -> list[Any]:
    """(k, runs) alarms at each rate, those of the default last; none behind the end of a record."""
    tracker = factory(seen.measurement, seen.route, law)
    found = track(tracker, seen.plots, Gaussian(seen.prior.mean, seen.prior.cov))
    looked = np.repeat(np.isfinite(seen.truth[:, 0]), seen.draws, axis=-1)
    alarms = []
    for test in (*map(ConformanceTest, RATES), CONFORMANCE):
        watch = test.watch(tracker, found)
        if watch is None:
            raise ValueError("the tracker has no intents, so there is no alert")
        alarms.append(watch.alarm & looked)
    return alarms


def lines(found: Conformance) -> Iterator[str]:
    """The operating curve as a table."""
    yield "| told: one in | false in 1000 looks | windows % | arrivals % | " + " | ".join(found.delays) + " s |"
    yield "|---" * (4 + len(found.delays)) + "|"
    for row, rate in enumerate(found.rates):
        told = f"{rate:g}" + (" (default)" if row == len(found.rates) - 1 else "")
        delays = " | ".join(f"{delay[row]:.0f}" for delay in found.delays.values())
        shares = f"{100 * found.windows[row]:.1f} | {100 * found.arrivals[row]:.1f}"
        yield f"| {told} | {found.false[row]:.2f} | {shares} | {delays} |"


def main() -> None:
    """Print the operating curve of intent_imm on both generators."""
    seed, count, draws = (int(sys.argv[i]) if len(sys.argv) > i else value for i, value in ((1, 1), (2, 60), (3, 4)))
    for kind in RADARS:
        print(f"\n{kind}, seed {seed}, {count} flights x {draws} draws")
        print("\n".join(lines(conformance(kind, seed, count, draws, TRACKERS["intent_imm"]))))


if __name__ == "__main__":
    main()

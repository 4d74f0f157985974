"""A reference line for a flight: the Cramer-Rao bound with every acceleration known, but no route."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.estimation.prior import PRIOR_POSITION, PRIOR_RATE
from sim.flight.interpolation import truth_at
from sim.flight.record import Flight

PLACES = (("north", "east"), ("range", "azimuth"))
MOST = 1500  # epochs; of more, every n-th counts n times


class PathBound(NamedTuple):
    """Standard deviations along the flown path."""

    time: np.ndarray  # (k,) s
    position: np.ndarray  # (k,) m, root of the trace
    cross_track: np.ndarray  # (k,) m


def path_bound(flight: Flight, sensors: dict[str, Any], records: dict[str, Any]) -> PathBound | None:
    """Cramer-Rao bound of position from all radar plots of a flight whose accelerations are known exactly.

    Only the place and velocity at the first plot are unknown, with the prior of the trackers; constant velocity then
    describes how their errors move, without process noise. Height is taken as known. A tracker that assumes a route and
    a law knows more, namely where the autopilot steers, and may be better across the track. None without a position
    sensor.
    """
    from tracking import bounds  # imports scipy, which a report without trackers does not need
    from tracking.motion import CARTESIAN, planar_constant_velocity

    stamps, informations = [], []
    for name, record in records.items():
        sensor = sensors[name]
        if not len(record.time) or not sensor.gives_place:
            continue
        rows = [record.channels.index(one) for one in PLACES[0 if "north" in record.channels else 1]]
        thin = max(1, -(-len(record.time) // MOST))
        time, z, R = record.time[::thin], record.z[::thin], record.R[::thin][:, rows][:, :, rows]
        R = R if R.ndim == 3 else R.mean(axis=-1)
        H = np.zeros((2, 4, len(time)))
        if "north" in record.channels:
            H[0, 0], H[1, 2] = 1.0, 1.0
        else:
            north, east, _ = truth_at(flight, time).position
            H = bounds.polar_jacobian(north - sensor.antenna[0], east - sensor.antenna[1], CARTESIAN)
        seen = thin * np.isfinite(z).all(axis=1).mean(axis=1)
        each = bounds.information(H, np.moveaxis(R, 0, -1))
        stamps.append(time)
        informations.append(np.moveaxis(each * seen, -1, 0))
    if not stamps:
        return None
    time = np.concatenate(stamps)
    order = np.argsort(time, kind="stable")
    time, J = time[order], np.concatenate(informations)[order]
    F = np.array([planar_constant_velocity(dt, 0.0, 0.0)[0] for dt in np.diff(time, prepend=time[0]).tolist()])
    prior = np.diag((PRIOR_POSITION, PRIOR_RATE) * 2) ** 2
    C = bounds.oracle_riccati(prior, F, np.zeros((4, 4)), J)[:, ::2, ::2]
    course = np.array([leg.course for leg in flight.route.legs])[truth_at(flight, time).leg]
    right = np.stack((-np.sin(course), np.cos(course)), axis=1)
    across = np.einsum("ki,kij,kj->k", right, C, right)
    return PathBound(time, np.sqrt(np.einsum("kii->k", C)), np.sqrt(across))

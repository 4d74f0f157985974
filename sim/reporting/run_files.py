"""The arrays of a run as its files hold them: every name carries its unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from aircraft.state import AircraftState
from sim.estimation.tracked.outcome import Tracked, joined
from sim.flight.record import Flight
from sim.observation.record import SensorRecord
from sim.observation.sensor import QUANTITIES, quantity_of


def flight_arrays(flight: Flight) -> dict[str, np.ndarray]:
    """The record of a flight by names that carry their unit."""
    state = {state_name(name): getattr(flight.state, name) for name in flight.state._fields}
    command = {f"command_{state_name(name)}": getattr(flight.command, name) for name in flight.command._fields}
    deviation = flight.deviation
    date = {} if flight.utc is None else {"utc_s": flight.utc + flight.time}  # since 1970
    return {
        **date,
        **state,
        **command,
        "cross_track_m": deviation.cross_track,
        "cross_track_rate_mps": deviation.cross_track_rate,
        "distance_to_go_m": deviation.distance_to_go,
        "leg": flight.leg,
        "phase": flight.phase,
        "phases": np.array(flight.phases),
    }


def state_of(arrays: dict[str, np.ndarray]) -> AircraftState:
    """The states of `flight_arrays`; raises ``KeyError`` where one is missing."""
    return AircraftState(*(arrays[state_name(name)] for name in AircraftState._fields))


SUFFIX_OF = {
    "s": ("time",),
    "m": ("north", "east", "height"),
    "mps": ("velocity_north", "velocity_east", "velocity_up", "airspeed", "equivalent_airspeed"),
    "rad": ("bank", "pitch", "heading", "angle_of_attack", "sideslip", "flaps", "flight_path_angle"),
    "radps": ("roll_rate", "pitch_rate", "yaw_rate"),
    "mps2": ("specific_force_forward", "specific_force_right", "specific_force_down"),
}


def state_name(name: str) -> str:
    """The name of a quantity of state or command in the files of a run."""
    return next((f"{name}_{suffix}" for suffix, names in SUFFIX_OF.items() if name in names), name)


def measurement_arrays(records: Mapping[str, SensorRecord]) -> dict[str, np.ndarray]:
    """The looks of all sensors: ``SENSOR.z`` in SI and radians with its channels beside it."""
    arrays: dict[str, np.ndarray] = {}
    for name, record in records.items():
        arrays[f"{name}.time_s"] = record.time
        arrays[f"{name}.arrival_s"] = record.arrival
        arrays[f"{name}.channels"] = np.array(record.channels)
        arrays[f"{name}.units"] = np.array([quantity_of(channel).si for channel in record.channels])
        arrays[f"{name}.z"] = record.z
        # of each channel by itself: what correlates them is not kept
        R = record.R if record.R.ndim == 4 else record.R[..., None]
        arrays[f"{name}.sigma"] = np.sqrt(np.einsum("kiin->kin", R))
        if record.candidates is not None:
            arrays |= {
                f"{name}.plots.{column}": values for column, values in plot_columns(record, record.candidates).items()
            }
    return arrays


def track_arrays(tracks: Mapping[str, Tracked]) -> Iterator[tuple[str, np.ndarray]]:
    """Estimates of all draws in single precision (a millimetre), the whole covariance of draw 0; by name, in turn."""
    for name, one in tracks.items():
        track = one.track if one.rollout is None else joined(one.track, one.rollout)
        cov = np.asarray(track.cov if track.cov.ndim == 4 else track.cov[..., None])
        with np.errstate(invalid="ignore"):  # a lost track is a result
            sigma = np.sqrt(np.einsum("kiin->kin", cov))
        one_draw = cov[..., 0].copy()  # a view would keep those of all draws
        del cov
        yield f"{name}.time_s", track.time
        yield f"{name}.channels", np.array(track.channels)
        yield f"{name}.mean", track.mean.astype(np.float32)
        yield f"{name}.sigma", sigma.astype(np.float32)
        yield f"{name}.cov_of_draw_0", one_draw
        if track.model_probabilities is not None:
            yield f"{name}.model_probabilities", np.asarray(track.model_probabilities)


def plot_columns(record: SensorRecord, candidates: np.ndarray) -> dict[str, np.ndarray]:
    """All plots of a sensor with clutter, one row each: when, in which draw, whether the target's own, and where."""
    plots = np.moveaxis(candidates, 2, -1)  # (k, c, draws, m)
    epoch, plot, draw = np.nonzero(np.isfinite(plots).all(axis=-1))
    places = plots[epoch, plot, draw].T
    return {
        "time_s": record.time[epoch],
        "arrival_s": record.arrival[epoch],
        "draw": draw,
        "target": (plot == 0).astype(int),
        **{
            with_unit(channel, quantity_of(channel).si): values
            for channel, values in zip(record.channels, places, strict=True)
        },
    }


ANGLES = ("azimuth", "elevation", "bearing", "course", "bank", "heading", "turn", "path_angle")  # others are lengths
PER_TIME = {"_rate": "ps", "_speed": "ps", "_acceleration": "ps2"}  # how a channel's name ends -> how its unit does


def with_unit(channel: str, si: str | None = None) -> str:
    """The channel, or its standard deviation, with the SI suffix of its quantity, where that is not given."""
    if si is not None:
        return f"{channel}_{si}" if si else channel
    plain = channel.removesuffix("_sigma")
    if plain.rpartition(".")[2] in QUANTITIES:
        si = quantity_of(plain).si
        return f"{channel}_{si}" if si else channel
    if "load_factor" in plain:
        return channel
    quantity = "rad" if any(angle in plain for angle in ANGLES) else "m"
    per_time = next((suffix for ending, suffix in PER_TIME.items() if plain.endswith(ending)), "")
    return f"{channel}_{quantity}{per_time}"

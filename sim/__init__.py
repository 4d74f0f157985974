"""An approach is flown, watched, tracked and judged: the verbs of the experiment and what passes between them.

>>> import sim
>>> result = sim.run("an26_pattern", seed=1)  # doctest: +SKIP
>>> result.flight.outcome  # doctest: +SKIP
'landed'

Everything on this page is imported as ``sim.NAME``; the module behind it is loaded when it is first asked for.

Verbs, in the order of a run
----------------------------
- `read` - a file, a bundled name or a dict of tables -> `Scenario` (sim.experiment)
- `prepare` - Scenario -> `Prepared`: route, law, gains and trim of one aircraft (sim.flight.preparation)
- `fly` - Prepared -> `Flight`: the closed loop of aircraft and autopilot (sim.experiment)
- `observe` - Flight and sensors -> a `SensorRecord` for each sensor (sim.observation.record)
- `track` - Prepared, Flight, records -> a `Tracked` for each tracker, and its figures (sim.estimation.tracking_run)
- `report` - `Result` and a folder -> the files of the run and its page, whose path it returns (sim.experiment)
- `identify` - Flight -> `LawFit`: the route law that flew the capture of a leg (sim.studies.identification.captures)
- `run` - all of them but the report, and the checks -> `Result` (sim.experiment)
- `compare` - two folders or results -> what changed beyond noise or tolerance (sim.studies.comparing.comparison)
- `study` - a scenario over the axes of its ``[study]`` -> `StudyResult` (sim.studies.studied)
- `explain` - what a scenario resolves to, as text: route, trim, modes, gains, limits, checks (sim.cli.explain)
- `linear` - a scenario -> `LinearSystems`: aircraft and loops for python-control (sim.flight.linear_systems.systems)
- `tracker` - a class of one's own, its sensors, law, route -> `OwnTracker` for run (sim.estimation.own_trackers)
- `figures` - Result -> names and titles of its figures, for `Result.plot` (sim.results.result)
- `load` - the folder of a run -> the Result that it was written from (sim.results.loading)
- `to_stonesoup` - Result -> truth, detections and tracks of one draw for Stone Soup (sim.results.stonesoup)
- `from_stonesoup` - tracks of Stone Soup -> what ``shortfinal judge`` takes (sim.results.stonesoup)
- `recorded` - recorded tracks and a runway -> a `Flight` for each, not flown here (sim.flight.recording.flights)

Units and frames
----------------
SI, radians, seconds; times count from the start of the flight. Only files, pages and the keys of metrics.json have
other units, and there every name carries its own (``_deg``, ``_kt``, ``_nmi``).

Runway frame: north, east and height in metres from the runway threshold; velocity north, east and up over the ground;
wind is the way the air moves. Heading, course and the bearing of a leg clockwise from north, pitch and path angle + up,
bank and cross-track + right. ``help(aircraft)`` has the earth, the body axes and the load factors.

Shapes: ``k`` instants come first, then ``m`` measured channels or ``n`` states, and last the noise draws. A covariance
that is the same for all draws has 1 of them, or no such axis. What is absent is NaN.

Data
----
- `Scenario` - a file as it was read, whole and checked, in SI (sim.scenario.model)
    - ``name``, ``seed``; ``flights``, each with its own air; ``draws`` of noise on each; ``until`` s or None
    - ``runway``, ``aircraft``, ``start``, ``route``, ``autopilot``, ``wind`` - their tables (sim.scenario.tables)
    - ``air`` - density, temperature and pressure over the runway (aircraft.air)
    - ``mode`` - the kind of law that flies, ``modes`` - the classes of all laws that are named; ``law`` - what the file
      sets of it; ``designed`` - gains it brings along; ``parts`` - kinds from outside that are named
    - ``record`` - the table of a flight that was flown elsewhere, or None (sim.scenario.recording.table)
    - ``sensors``, ``trackers`` - by name; ``departures`` from the law, ``sensor_faults``; ``contrasts`` of trackers;
      ``checks``; ``study``; ``navigation_errors`` of the autopilot, or None
    - ``tables`` - the resolved file itself, in its own spelling
- `Prepared` - all that one flight needs, built once (sim.flight.preparing.prepared)
    - ``scenario``; ``autopilot`` with its route and law; ``vehicle``, JSBSim or a point mass; ``initial`` state
    - ``limits`` that end a flight; ``gains``, their design and what it was made for; ``designed``, the gains
      that fly; ``rate`` Hz of the equations of motion; ``warnings``, sentences; ``stall_speed`` m/s equivalent of
      the landing, or None; ``recording`` - a `Flight` that was flown elsewhere, in place of one that is flown, or None
- `Flight` - the record of one flight, k instants at 30 Hz (sim.flight.record)
    - ``time`` (k,) s; ``state`` and ``command`` - `AircraftState` and `Command` of arrays (k,)
    - ``route`` that was to be flown; ``leg`` (k,) - index of the active one; ``deviation`` from it, of arrays (k,)
    - ``phase`` (k,) - index into ``phases``, their names; ``wind`` (3, k) m/s north, east, up
    - ``events`` - (time s, name, detail); ``outcome`` - landed, go_around, completed, ground, orbit, diverged, envelope
      or time_limit; ``reason``, a sentence; ``gate_height`` m of the stabilised-approach gate, None = no landing
    - ``rollout`` - from the landing to the stop, a `Flight` too (outcome stopped, excursion, time_limit or diverged),
      or None; ``whole`` - both as one record; ``utc`` s since 1970 at time 0, or None
    - of a recorded flight all but motion and bank is NaN, commands too; its phases are vectors, capture, established,
      glide and ground. Where only plots tell of it all is NaN, ``known`` is False and the outcome unknown
- `AircraftState` - one instant of motion, or a record of arrays (aircraft.state)
    - ``time`` s; ``north``, ``east``, ``height`` m; ``velocity_north``, ``velocity_east``, ``velocity_up`` m/s
    - ``bank``, ``pitch``, ``heading`` rad; ``roll_rate``, ``pitch_rate``, ``yaw_rate`` rad/s, body axes
    - ``airspeed`` m/s, true; ``equivalent_airspeed`` m/s; ``angle_of_attack``, ``sideslip`` rad, + wind from the right
    - ``specific_force_forward``, ``specific_force_right``, ``specific_force_down`` m/s2, body axes, all but gravity
    - ``aileron``, ``elevator``, ``rudder`` -1..1, + rolls right, pitches up, yaws right; ``throttle`` 0..1
    - ``flaps`` rad; ``gear`` 0 up, 1 down; ``main_wheels`` 0..1, the share of them on the ground
    - ``first_contact``, ``touched`` - what touched the ground first, and so far: sums of parts
      (aircraft.state.PARTS), 0 = none yet
    - what follows from them: ``course``, ``ground_speed``, ``air_velocity``, ``flight_path_angle`` and ``air_course``
      through the air, ``aerodynamic_bank``, ``load_factor``, ``acceleration``
- `Command` - what the autopilot asks of the inner loops (aircraft.state)
    - ``bank`` rad; ``flight_path_angle`` rad over the ground; ``height`` m, NaN = not held; ``airspeed`` m/s, true
    - ``flaps`` rad; ``gear`` 0 or 1; ``sideslip`` rad
- `SensorRecord` - all looks of one sensor at one flight (sim.observation.record)
    - ``channels`` - m names such as range, azimuth, elevation; ``time`` (k,) s, when it was true; ``arrival`` (k,) s,
      when it was known
    - ``z`` (k, m, draws) SI; of an antenna its slant range, the azimuth clockwise from its zero, the elevation + up
    - ``R`` (k, m, m, draws), the covariance of z; ``candidates`` (k, c, m, draws), false plots too, or None
- `Measurements` - the looks of several sensors as one tracker gets them (tracking.track)
    - ``channels`` - m names, "SENSOR.QUANTITY"; ``time``, ``arrival`` (k,) s; ``z`` (k, m, draws), NaN = not then
    - ``R`` (k, m, m, draws); ``candidates`` (k, c, m, draws) or None
- `Track` - the estimates of one tracker, after each of k updates (tracking.track)
    - ``channels`` - n names, north, north_rate, east, east_rate for most; ``time`` (k,) s
    - ``mean`` (k, n, draws) and ``cov`` (k, n, n, draws), SI in the runway frame or that of its sensor
    - ``white`` (k, m, draws) - residuals of unit variance; ``nis``, ``log_likelihood`` (k, draws)
    - ``model_probabilities`` (k, M, draws) of M models, or None
    - ``skipped`` (k, draws) looks of which something could not be used, None = all were
    - of more than 512 draws these arrays lie in files: ``np.asarray`` or an index reads them
- `Tracked` - one tracker, its record and what that had wrong (sim.estimation.tracked.outcome)
    - ``tracker``, as it was set up; ``law_from`` - origin of the law it assumes, None = none known; ``measurements``
      that it was given (of more than 512 draws, in the first of them); ``track``; ``curves`` - its errors over time,
      for figures (sim.metrics.error_curves); ``rollout`` - its Track after the landing, or None; ``squares`` - its
      squared errors by time where the scenario contrasts it (sim.metrics.contrasts), or None
- `LawFit` - the route law that comes nearest to a capture (autopilot.identification)
    - ``k1`` rad/m, ``k2`` rad/(m/s), ``cross_track_limit`` m, ``bank_limit`` rad, and ``lag`` s of the bank: each with
      its value, its standard error sigma, and met = False for a limit that never acted and is no less than the value
    - ``line`` m, the cross-track of the line that it held, likewise; ``engaged`` s, when it took over from a held
      course, or None where it flew all of the capture
    - ``cross_track_rms`` m, ``bank_rms`` rad - what the law leaves; ``explained``, and ``objections``, sentences
    - ``capture`` - the record of it; ``flown`` - the same by the law; ``frequency`` rad/s and ``damping`` of the law
- `Result` - what a run found out (sim.results.result)
    - ``prepared``, ``scenario``; ``metrics`` - as in metrics.json, of all flights; ``contrasted`` - sentences about
      each pair of trackers that are set against each other; ``broken`` - one for each check that failed; ``timing`` s;
      ``own`` - trackers that the caller brought
    - of one flight, the first or the only one, everything: its ``number``; ``flight``; ``records`` and ``tracks`` -
      SensorRecord and Tracked by name. ``sim.run(..., flight=3)`` has another
    - ``plot`` draws a figure by name with matplotlib, ``to_dataframe`` gives a table to pandas: flight, measurements,
      trackers or errors; ``save`` writes the folder that `load` reads
- `StudyResult` - what a study found out (sim.results.studied)
    - ``folder`` that holds it, or None; ``metrics`` - as in its metrics.json; ``broken`` - one sentence for each check
      that failed
- `LinearSystems` - linear models about the leg on which a flight begins (sim.flight.linear_systems.systems)
    - ``leg``, at whose airspeed and height they hold; ``aircraft``, ``bank``, ``opened`` (at the bank command) and
      ``closed`` - each a control.StateSpace whose signals have names with units, all but the aircraft sampled at 30 Hz
    - ``loop`` - the matrices of the sampled loops (autopilot.route_loop); ``law`` that closes them
- `OwnTracker` - a tracker of the caller with what it is given (sim.estimation.own_trackers)
    - ``made`` - a tracker, or the class that makes one; ``sensors`` it listens to, None = all that it can read; ``law``
      - "autopilot", changes to that, or None; ``route`` - whether it is given that; ``parameters`` of its class

Errors
------
Both are a ``ValueError`` with a sentence for the user.

- `ScenarioError` - a scenario that cannot be run: one line for each fault, with its place and the mend (sim.errors)
- `OutputError` - a folder that cannot be written or read, or a program to be used that does not answer (sim.errors)
"""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aircraft.state import AircraftState, Command
    from autopilot.identification import LawFit
    from sim.cli.explain import explain
    from sim.errors import OutputError, ScenarioError
    from sim.estimation.own_trackers import OwnTracker, tracker
    from sim.estimation.tracked.outcome import Tracked
    from sim.estimation.tracking_run import track
    from sim.experiment import fly, read, report, run
    from sim.flight.linear_systems.systems import LinearSystems, linear
    from sim.flight.preparation import Prepared, prepare
    from sim.flight.record import Flight
    from sim.flight.recording.flights import recorded
    from sim.observation.record import SensorRecord, observe
    from sim.results.loading import load
    from sim.results.result import Result, figures
    from sim.results.stonesoup import from_stonesoup, to_stonesoup
    from sim.results.studied import StudyResult
    from sim.scenario.model import Scenario
    from sim.studies.comparing.comparison import compare
    from sim.studies.identification.captures import identify
    from sim.studies.studied import study
    from sim.versions import __version__ as __version__
    from tracking.track import Measurements, Track

__all__ = [
    "AircraftState",
    "Command",
    "Flight",
    "LawFit",
    "LinearSystems",
    "Measurements",
    "OutputError",
    "OwnTracker",
    "Prepared",
    "Result",
    "Scenario",
    "ScenarioError",
    "SensorRecord",
    "StudyResult",
    "Track",
    "Tracked",
    "compare",
    "explain",
    "figures",
    "fly",
    "from_stonesoup",
    "identify",
    "linear",
    "load",
    "observe",
    "prepare",
    "read",
    "recorded",
    "report",
    "run",
    "study",
    "to_stonesoup",
    "track",
    "tracker",
]

_HOMES = {
    "aircraft.state": ("AircraftState", "Command"),
    "autopilot.identification": ("LawFit",),
    "sim.cli.explain": ("explain",),
    "sim.errors": ("OutputError", "ScenarioError"),
    "sim.estimation.own_trackers": ("OwnTracker", "tracker"),
    "sim.estimation.tracked.outcome": ("Tracked",),
    "sim.estimation.tracking_run": ("track",),
    "sim.experiment": ("fly", "read", "report", "run"),
    "sim.flight.linear_systems.systems": ("LinearSystems", "linear"),
    "sim.flight.preparation": ("prepare",),
    "sim.flight.preparing.prepared": ("Prepared",),
    "sim.flight.record": ("Flight",),
    "sim.flight.recording.flights": ("recorded",),
    "sim.observation.record": ("SensorRecord", "observe"),
    "sim.results.loading": ("load",),
    "sim.results.result": ("Result", "figures"),
    "sim.results.stonesoup": ("from_stonesoup", "to_stonesoup"),
    "sim.results.studied": ("StudyResult",),
    "sim.scenario.model": ("Scenario",),
    "sim.studies.comparing.comparison": ("compare",),
    "sim.studies.identification.captures": ("identify",),
    "sim.studies.studied": ("study",),
    "sim.versions": ("__version__",),
    "tracking.track": ("Measurements", "Track"),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}


def _refuse_strangers() -> None:
    """The four import names are generic: say so in one sentence when another distribution shadows one."""
    home = Path(__file__).resolve().parent.parent
    for name in ("aircraft", "autopilot", "tracking"):
        spec = importlib.util.find_spec(name)
        found = Path(spec.origin).resolve() if spec is not None and spec.origin else None
        if found is None or found.parent.parent != home:
            raise ImportError(
                f"shortfinal's package '{name}' is shadowed by {found or 'nothing at all'}; "
                f"remove that distribution or use a fresh environment"
            )


_refuse_strangers()

if not TYPE_CHECKING:  # a type checker sees the imports above, and refuses what is not among them

    def __getattr__(name: str) -> object:
        if name in _HOME_OF:
            return getattr(importlib.import_module(_HOME_OF[name]), name)
        raise AttributeError(f"module 'sim' has no attribute '{name}'")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

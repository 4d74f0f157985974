"""Run by an interpreter that has fastkml, flightgear-python and Stone Soup, for the acceptance tests of the views.

``kml FILE`` reads a KMZ strictly and says whether it is valid by the schema, and the names in it. ``packets FILE
EXPECTED`` parses packets that stand one after another and prints by field the largest difference from arrays in an
npz file, relative where a value is above 1. ``stonesoup`` runs the scenario on standard input, hands it over and back,
and lets Stone Soup track and judge it.
"""

from __future__ import annotations

import json
import pathlib
import sys
import tempfile
import zipfile

import numpy as np


def kml(path):
    """Whether the document is valid, and the names of what is in it."""
    from fastkml import KML
    from fastkml.validator import validate

    document = zipfile.ZipFile(path).read("doc.kml")
    with tempfile.TemporaryDirectory() as place:
        file = pathlib.Path(place) / "doc.kml"
        file.write_bytes(document)
        by_schema = validate(file_to_validate=file)
        read = KML.parse(file, strict=True, validate=True)
    marks = read.features[0].features
    return {"valid": bool(by_schema and read.validate()), "names": [mark.name for mark in marks]}


def packets(path, expected):
    """The largest difference by field, over all packets."""
    from flightgear_python.fdm_v24 import fdm_struct

    octets, size = pathlib.Path(path).read_bytes(), fdm_struct.sizeof()
    assert len(octets) % size == 0
    parsed = [fdm_struct.parse(octets[at : at + size]) for at in range(0, len(octets), size)]
    worst = {}
    for name, wanted in np.load(expected).items():
        found = np.array([np.array(one[name], float) for one in parsed])
        worst[name] = float(np.max(np.abs(found - wanted) / np.maximum(1.0, np.abs(wanted))))
    return {"packets": len(parsed), "worst": worst}


def stonesoup(tables):
    """Round trip, metrics of Stone Soup beside ours, and its extended Kalman filter on our detections."""
    import sim

    result = sim.run(tables)
    end = float(result.flight.time[-1])
    found = {"round_trip": 0.0, "stamps": 0.0, "rmse": {}, "mean": {}, "distance": {}, "rms": {}}
    errors = result.to_dataframe("errors")
    filtered = []
    for draw in range(result.scenario.draws):
        given = sim.to_stonesoup(result, draw)
        for name, track in given.tracks.items():
            found["round_trip"] = max(found["round_trip"], round_trip(result.tracks[name], track, draw))
            own = errors[(errors["tracker"] == name) & (errors["draw"] == draw)]["position_m"]
            distance, square = accuracy(given.truth, track, end)
            for table, value in (("distance", distance), ("rms", square), ("mean", float(own.mean())),
                                 ("rmse", float((own**2).mean()))):  # fmt: skip
                found[table].setdefault(name, []).append(value)
        filtered.append(extended_kalman(given.detections["terminal"]))
    for table in ("distance", "mean"):
        found[table] = {name: float(np.mean(values)) for name, values in found[table].items()}
    for table in ("rms", "rmse"):
        found[table] = {name: float(np.sqrt(np.mean(values))) for name, values in found[table].items()}
    found["ours"] = {
        name: one["overall"]["position_m"]["rmse"] for name, one in result.metrics["trackers"].items()
    }  # fmt: skip
    found["judged"] = judged(result, filtered)
    return found


def round_trip(tracked, track, draw):
    """The largest difference of means and covariances that came back, and of stamps beyond Stone Soup's microsecond."""
    import sim
    from sim.estimation.tracked.outcome import joined

    own = tracked.track if tracked.rollout is None else joined(tracked.track, tracked.rollout)
    back = sim.from_stonesoup(track)
    cov = own.cov[:, [0, 2]][:, :, [0, 2]]
    cov = cov if cov.ndim == 3 else cov[..., draw if cov.shape[3] > 1 else 0]
    assert np.abs(back.stamps.time - own.time).max() <= 0.5e-6
    return max(
        float(np.abs(back.local - own.mean[:, [0, 2], draw]).max()),
        float(np.abs(back.velocity - own.mean[:, [1, 3], draw]).max()),
        float(np.abs(back.cov - cov).max()),
    )


def accuracy(truth, track, end):
    """SIAP position accuracy to the end of the flight, of distances and of their squares."""
    from datetime import timedelta

    from stonesoup.dataassociator.tracktotrack import TrackToTruth
    from stonesoup.measures import Euclidean
    from stonesoup.metricgenerator.manager import MultiManager
    from stonesoup.metricgenerator.tracktotruthmetrics import SIAPMetrics
    from stonesoup.types.groundtruth import GroundTruthPath
    from stonesoup.types.track import Track

    from sim.results.stonesoup import START

    last = START + timedelta(seconds=end)
    own = Track([state for state in track if state.timestamp <= last])
    stamps = {state.timestamp for state in own}
    path = GroundTruthPath([state for state in truth if state.timestamp in stamps])
    place, rate = Euclidean((0, 2)), Euclidean((1, 3))
    kinds = {"distance": place, "square": lambda one, other: place(one, other) ** 2}
    generators = [SIAPMetrics(measure, rate, generator_name=name) for name, measure in kinds.items()]
    manager = MultiManager(generators, TrackToTruth(association_threshold=np.inf, measure=place))
    manager.add_data({"tracks": {own}, "groundtruth_paths": {path}})
    metrics = manager.generate_metrics()
    assert metrics["distance"]["SIAP Completeness"].value == 1.0
    return tuple(float(metrics[name]["SIAP Position Accuracy"].value) for name in kinds)


def extended_kalman(looks):
    """A track of constant velocity by Stone Soup's filter, from the first detection on."""
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import ExtendedKalmanPredictor
    from stonesoup.types.hypothesis import SingleHypothesis
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track
    from stonesoup.updater.kalman import ExtendedKalmanUpdater

    predictor = ExtendedKalmanPredictor(CombinedLinearGaussianTransitionModel([ConstantVelocity(4.0)] * 2))
    updater = ExtendedKalmanUpdater(measurement_model=None)
    track = Track()
    for stamp, plots in looks:
        for plot in plots:
            if not track:
                start = plot.measurement_model.inverse_function(plot)
                track.append(GaussianState(start, np.diag((400.0, 100.0, 400.0, 100.0)) ** 2, stamp))
            prediction = predictor.predict(track[-1], timestamp=stamp)
            track.append(updater.update(SingleHypothesis(prediction, plot)))
    return Track(track[1:])


def judged(result, tracks):
    """What `judge` says of tracks of Stone Soup, beside the plots."""
    import sim
    from sim.results.judging import with_track

    with tempfile.TemporaryDirectory() as place:
        folder = result.save(pathlib.Path(place) / "run")
        file = sim.from_stonesoup(*tracks).save(pathlib.Path(place) / "mine.csv")
        figures = sim.run(with_track(folder, "mine", file, ["terminal"])).metrics["trackers"]["mine"]
    return {**figures["overall"]["position_m"], "anees": figures["anees"], **figures["track"]}


if __name__ == "__main__":
    command, *arguments = sys.argv[1:]
    commands = {"kml": kml, "packets": packets, "stonesoup": lambda: stonesoup(json.load(sys.stdin))}
    print(json.dumps(commands[command](*arguments)))

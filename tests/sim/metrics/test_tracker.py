"""The gain of a tracker over its measurements, with its paired interval."""

from __future__ import annotations

import numpy as np
import pytest

import sim
from sim.metrics.tracker import _figure


def test_the_noise_that_a_tracker_shares_with_its_plots_is_not_in_the_interval():
    """A tracker that halves every draw's error has a gain of 2 for sure, however much the draws differ."""
    raw = np.random.default_rng(1).exponential(100.0, (40, 30)) * np.linspace(1.0, 5.0, 30)
    alike, apart = _figure(raw / 4.0, raw, None), _figure(raw[:, ::-1] / 4.0, raw, None)
    assert alike["gain_low"] == pytest.approx(2.0, rel=1e-12)
    assert alike["gain_high"] == pytest.approx(2.0, rel=1e-12)
    assert apart["gain"] == pytest.approx(2.0, rel=1e-12)
    assert apart["gain_low"] < 1.9
    assert apart["gain_high"] > 2.1


def test_the_interval_is_that_of_the_gain_where_looks_are_missed():
    """Draws count by their looks, so the middle of the interval (of its logarithm) is the pooled ratio."""
    rng = np.random.default_rng(2)
    squares, raw = rng.exponential(1.0, (50, 20)), rng.exponential(9.0, (50, 20))
    raw[rng.random(raw.shape) < np.linspace(0.0, 0.9, 20)] = np.nan
    found = _figure(squares, raw, None)
    assert found["gain"] == pytest.approx(np.sqrt(np.nansum(raw) / squares[np.isfinite(raw)].sum()), rel=1e-12)
    assert np.sqrt(found["gain_low"] * found["gain_high"]) == pytest.approx(found["gain"], rel=1e-12)


def test_its_lower_end_can_be_asked_for():
    """It is there overall and by phase, and a check judges by it."""
    tables = sim.read("route_capture_point_mass").tables | {
        "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 4, "position_sigma_m": 100}},
        "trackers": {"mine": {"kind": "saturated_control"}},
        "checks": [{"metric": "trackers.mine.overall.position_m.gain_low", "min": 1.5, "source": "a test"}],
        "draws": 20,
        "until_s": 120,
    }
    result = sim.run(tables)
    (check,) = result.metrics["checks"]
    overall = result.metrics["trackers"]["mine"]["overall"]["position_m"]
    assert 1.5 < overall["gain_low"] < overall["gain"] < overall["gain_high"]
    for by in result.metrics["trackers"]["mine"]["by_phase"].values():
        assert by["position_m"]["gain_low"] < by["position_m"]["gain"] < by["position_m"]["gain_high"]
    assert check["passed"] is True
    assert check["value"] == overall["gain_low"]

"""Judge: the equation of continuity, the peak where it is said, and the shape of CS 25.341(a)."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from aircraft.wind_events.gust import Gust
from aircraft.wind_events.microburst import FRICTION, GROWTH, Microburst
from aircraft.wind_events.wind_shift import WindShift


@dataclasses.dataclass(frozen=True)
class East:
    """A runway that runs east."""

    def to_local(self, past_threshold, right):
        return -right, past_threshold


RUNWAY = East()


def microburst(**given):
    return Microburst(**{"peak": 15.0, "past_threshold": -2000.0, "runway": RUNWAY, **given})


def wind(event, north, east, height, time=0.0):
    return np.array(event.velocity(time, (north, east, height), 70.0))


POINTS = list(itertools.product((-1700.0, -400.0, 3.0, 900.0, 2600.0), (-3900.0, -2010.0, -700.0), (5.0, 60.0, 300.0)))


@pytest.mark.parametrize("shape", [{}, {"radius": 700.0, "height": 40.0}])
def test_the_microburst_has_no_divergence(shape):
    """du/dx + dv/dy + dw/dz = 0, in the axes of the runway and not in those of the model."""
    event, step = microburst(**shape), 0.05
    for place in POINTS:
        slopes = []
        for axis in range(3):
            shift = step * np.eye(3)[axis]
            slopes.append((wind(event, *(place + shift)) - wind(event, *(place - shift)))[axis] / (2.0 * step))
        # central differences over 0.1 m of a field that bends over no less than 12 m: (0.05/12)^2 / 6 = 3e-6 of a slope
        assert sum(slopes) == pytest.approx(0.0, abs=3e-6 * event.peak / event.height)


def test_what_sinks_through_a_lid_leaves_through_the_wall():
    """Continuity in the large: the flux down through a disc is the flux out of the cylinder below it."""
    event = microburst()
    for radius, lid in ((400.0, 50.0), (1550.0, 200.0), (2500.0, 400.0)):
        inner = np.linspace(0.0, radius, 4001)
        down = -np.array([event.outflow(float(r), lid)[1] for r in inner]) * 2.0 * np.pi * inner
        heights = np.linspace(0.0, lid, 4001)
        out = np.array([event.outflow(radius, float(h))[0] for h in heights]) * radius * 2.0 * np.pi * radius
        assert np.trapezoid(down, inner) == pytest.approx(np.trapezoid(out, heights), rel=1e-5)


@pytest.mark.parametrize("shape", [{}, {"radius": 600.0, "height": 30.0}])
def test_the_greatest_outflow_is_what_and_where_it_is_said(shape):
    event = microburst(**shape)
    radii, heights = np.linspace(0.0, 3.0 * event.radius, 301), np.linspace(0.0, 8.0 * event.height, 401)
    speeds = np.array([[event.outflow(float(r), float(h))[0] * r for r in radii] for h in heights])
    up, out = np.unravel_index(np.argmax(speeds), speeds.shape)
    assert speeds.max() == pytest.approx(15.0, rel=1e-4)  # the grid holds the peak to half a step
    assert (radii[out], heights[up]) == pytest.approx((event.radius, event.height), rel=0.02)


def test_the_constants_put_the_peak_at_its_height():
    assert GROWTH * math.exp(GROWTH) == pytest.approx(FRICTION * math.exp(FRICTION), rel=1e-6)


def test_nothing_moves_on_the_ground_nor_below():
    event = microburst()
    for height in (0.0, -3.0):
        assert wind(event, 300.0, -1500.0, height) == pytest.approx(np.zeros(3), abs=1e-12)


def test_air_sinks_inside_rises_in_a_ring_and_is_still_far_away():
    event = microburst()
    edge = event.radius * 2.0**0.25  # where 1 - (r/rp)^4 / 2 changes sign
    assert event.outflow(0.0, 200.0)[1] < -3.0
    assert event.outflow(0.98 * edge, 200.0)[1] < 0.0 < event.outflow(1.02 * edge, 200.0)[1]
    assert event.outflow(3.1 * event.radius, 75.0) == (0.0, 0.0)
    rim = event.outflow(2.99 * event.radius, 75.0)
    assert abs(rim[0] * 3.0 * event.radius) + abs(rim[1]) < 1e-6  # m/s, the step where it is cut off


def test_it_blows_away_from_its_centre_on_every_side():
    event = microburst(right=500.0)  # of a runway that runs east: 500 m to the south
    assert event.centre == pytest.approx((-500.0, -2000.0))
    for bearing in np.radians((0.0, 77.0, 200.0, 290.0)):
        out = np.array((math.cos(bearing), math.sin(bearing)))
        north, east, _ = wind(event, *(np.array(event.centre) + 1550.0 * out), 75.0)
        assert (north, east) == pytest.approx(15.0 * out, rel=1e-6)


def test_it_swells_and_fades():
    event = microburst(at=100.0, lasts=40.0)
    still = microburst()
    place = (300.0, -1500.0, 60.0)
    for time, share in ((99.0, 0.0), (110.0, 0.5), (120.0, 1.0), (130.0, 0.5), (141.0, 0.0)):
        assert wind(event, *place, time) == pytest.approx(share * wind(still, *place), abs=1e-12)


def test_strength_only_scales_it():
    for place in POINTS[::7]:
        assert wind(microburst(peak=30.0), *place) == pytest.approx(2.0 * wind(microburst(), *place), rel=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        {"peak": -1.0}, {"peak": math.nan}, {"peak": 101.0}, {"past_threshold": math.nan}, {"right": math.inf},
        {"radius": 0.0}, {"radius": math.nan}, {"height": -3.0}, {"height": 2000.0}, {"at": 5.0}, {"lasts": 5.0},
        {"at": -1.0, "lasts": 5.0}, {"at": 1.0, "lasts": 0.0}, {"at": 1.0, "lasts": math.nan},
    ],
)  # fmt: skip
def test_impossible_microbursts_are_refused(wrong):
    with pytest.raises(ValueError, match=r"microburst|^(peak|radius|height|at|lasts) must be"):
        microburst(**wrong)


# ---- gusts -------------------------------------------------------------------------------------------------------


def test_a_gust_at_a_time_is_one_minus_cosine():
    gust = Gust(up=9.0, at=60.0, lasts=4.0)
    for after in np.linspace(0.0, 4.0, 17):
        wanted = 0.5 * 9.0 * (1.0 - math.cos(2.0 * math.pi * after / 4.0))
        assert wind(gust, 5.0, 6.0, 7.0, 60.0 + after) == pytest.approx((0.0, 0.0, wanted), abs=1e-12)
    assert not wind(gust, 5.0, 6.0, 7.0, 59.9).any()
    assert not wind(gust, 5.0, 6.0, 7.0, 64.1).any()


def test_a_gust_blows_from_where_it_says():
    gust = Gust(speed=10.0, from_=math.radians(270.0), at=0.0, lasts=2.0)
    assert wind(gust, 0.0, 0.0, 50.0, 1.0) == pytest.approx((0.0, 10.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("bearing", [0.0, 40.0, 90.0, 300.0])
def test_a_gust_at_a_place_has_the_same_shape_from_any_side(bearing):
    gust = Gust(up=8.0, past_threshold=-1000.0, right=200.0, length=150.0, runway=RUNWAY)
    along = np.array((math.cos(math.radians(bearing)), math.sin(math.radians(bearing))))
    for flown in np.linspace(-100.0, 100.0, 41):
        place = np.array((-200.0, -1000.0)) + flown * along
        inside = abs(flown) < 75.0
        wanted = 4.0 * (1.0 - math.cos(2.0 * math.pi * (flown + 75.0) / 150.0)) if inside else 0.0
        assert wind(gust, *place, 120.0)[2] == pytest.approx(wanted, abs=1e-9)


def test_beside_its_middle_a_gust_is_weaker():
    gust = Gust(up=8.0, past_threshold=-1000.0, length=150.0, runway=RUNWAY)
    beside = max(wind(gust, 40.0, float(east), 50.0)[2] for east in np.linspace(-1100.0, -900.0, 201))
    assert 0.0 < beside < 0.6 * 8.0  # 1 - cos at 35 m from the edge of 150 m: 0.55


def test_a_wind_shift_sets_in_and_stays():
    shift = WindShift(speed=6.0, from_=math.radians(180.0), up=1.0, at=10.0, lasts=4.0)
    for time, share in (
        (9.0, 0.0),
        (11.0, 0.5 - 0.5 * math.cos(math.pi / 4.0)),
        (12.0, 0.5),
        (14.0, 1.0),
        (900.0, 1.0),
    ):
        assert wind(shift, 5.0, 6.0, 7.0, time) == pytest.approx(share * np.array((6.0, 0.0, 1.0)), abs=1e-12)


@pytest.mark.parametrize("aside", [-3000.0, 0.0, 800.0])
def test_a_wind_shift_at_a_place_is_a_line_across_the_runway(aside):
    shift = WindShift(speed=6.0, from_=math.radians(180.0), past_threshold=-2000.0, length=400.0, runway=RUNWAY)
    for east, share in ((-2001.0, 0.0), (-1800.0, 0.5), (-1600.0, 1.0), (3000.0, 1.0)):
        assert wind(shift, aside, east, 50.0)[0] == pytest.approx(6.0 * share, abs=1e-12)


@pytest.mark.parametrize("kind", [Gust, WindShift])
@pytest.mark.parametrize(
    "wrong",
    [
        {}, {"at": 5.0}, {"lasts": 5.0}, {"past_threshold": 5.0}, {"length": 5.0},
        {"at": 5.0, "lasts": 2.0, "length": 100.0}, {"at": 5.0, "lasts": 2.0, "past_threshold": 1.0, "length": 100.0},
        {"at": -5.0, "lasts": 2.0}, {"at": 5.0, "lasts": 0.0}, {"past_threshold": 5.0, "length": -100.0},
        {"at": math.nan, "lasts": 2.0}, {"past_threshold": math.inf, "length": 10.0},
        {"at": 5.0, "lasts": 2.0, "speed": -1.0}, {"at": 5.0, "lasts": 2.0, "up": math.nan},
        {"at": 5.0, "lasts": 2.0, "up": -200.0},
    ],
)  # fmt: skip
def test_impossible_gusts_and_shifts_are_refused(kind, wrong):
    with pytest.raises(
        ValueError, match=r"of a gust|of a wind shift|say one of them|^(speed|up|at|lasts|length) must be"
    ):
        kind(runway=RUNWAY, **wrong)

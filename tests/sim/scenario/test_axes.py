"""What axes draw: distributions as a file states them, and sentences for those that are none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from sim.scenario.axes import axis, samples

DRAWS = 4000


def drawn(**form):
    one = axis("wind.headwind_kt", form)
    return np.array([row["wind.headwind_kt"] for row in samples([one], DRAWS, 5)]), one


def test_a_bounded_normal_is_the_truncated_one():
    values, one = drawn(normal=[7.5, 7.5, -10, 30])
    assert values.min() >= -10
    assert values.max() <= 30
    assert kstest(values, truncnorm((-10 - 7.5) / 7.5, (30 - 7.5) / 7.5, 7.5, 7.5).cdf).pvalue > 0.01
    assert one.typical == 7.5


def test_a_normal_whose_mean_is_out_of_bounds_is_still_drawn_within():
    values, one = drawn(normal=[0, 1, 2, 3])
    assert values.min() >= 2
    assert one.typical == 2


def test_quantiles_are_met_and_between_them_all_is_equally_likely():
    points = [[0, -300.0], [0.5, 80.0], [0.8, 230.0], [1, 2800.0]]
    values, one = drawn(quantiles=points)
    shares, at = zip(*points, strict=True)
    assert kstest(values, lambda x: np.interp(x, at, shares)).pvalue > 0.01
    assert one.typical == -300.0


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ({"normal": [0, 1, 2]}, "normal needs 2 or 4 finite numbers"),
        ({"normal": [0, 1, 3, 2]}, "needs its low end below its high end, not 3 and 2"),
        ({"normal": [0, 1, 8, 9]}, "almost nothing of this normal lies within 8 and 9"),
        ({"normal": [0, 0, -1, 1]}, "almost nothing of this normal"),
        ({"quantiles": [[0, 1]]}, "two or more pairs of a share and a value"),
        ({"quantiles": [[0, 1], [1, "2"]]}, "quantiles needs finite numbers"),
        ({"quantiles": [[0.1, 1], [1, 2]]}, "rise from 0 to 1"),
        ({"quantiles": [[0, 1], [0.5, 2], [0.5, 3], [1, 4]]}, "rise from 0 to 1"),
        ({"quantiles": [[0, 2], [1, 1]]}, "must not fall as their shares rise"),
        ({"quantiles": 3}, "two or more pairs"),
        ({"weibull": [1, 2]}, "no form 'weibull'"),
    ],
)
def test_a_form_that_is_none_is_one_sentence(form, said):
    with pytest.raises(ValueError, match=r'^axes "wind\.headwind_kt": ') as refused:
        axis("wind.headwind_kt", form)
    assert said in str(refused.value)

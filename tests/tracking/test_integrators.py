"""Chains of integrators against the matrix exponential."""

from __future__ import annotations

import numpy as np
import pytest

from tracking.integrators import integrators
from tracking.motion import van_loan


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("ratio", [0.02, 0.5, 1.0])
def test_block_matrices_are_the_matrix_exponential(order, ratio):
    A = np.diag(np.ones(order - 1), 1)
    A[-1, -1] = -1.0 / 5.0
    expected = van_loan(A, np.diag([*[0.0] * (order - 1), 0.7]), 5.0 * ratio)
    F, Q = integrators(order, 5.0, 0.7, 5.0 * ratio)
    np.testing.assert_allclose(F, expected[0], rtol=1e-10)
    np.testing.assert_allclose(Q, expected[1], rtol=1e-9)
    several = integrators(order, 5.0, 0.7, np.array([0.0, 5.0 * ratio]))
    np.testing.assert_array_equal(several[0][..., 1], F)
    np.testing.assert_array_equal(several[0][..., 0], np.eye(order))
    np.testing.assert_array_equal(several[1][..., 0], 0.0)

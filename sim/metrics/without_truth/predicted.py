"""How far ahead a track is good, against the plots that came: their own errors are in the figures."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Predicted(NamedTuple):
    """n predictions of later plots."""

    error: np.ndarray  # (n, 2, draws) m, predicted less measured, north and east
    cov: np.ndarray  # (n, 2, 2, draws) m2, of the prediction and of the plot


def predicted_figures(predicted: dict[str, Predicted]) -> dict[str, dict[str, Any]]:
    """By span: RMSE, m, and the normalised square per dimension, which is 1 where the covariances are right."""
    found = {}
    for span, (error, cov) in predicted.items():
        a, b, c = cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1]
        x, y = error[:, 0], error[:, 1]
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
            normalised = (c * x * x - 2.0 * b * x * y + a * y * y) / (a * c - b * b) / 2.0
            found[span] = {
                "rmse_m": float(np.sqrt(np.mean(x * x + y * y))),
                "normalised": float(np.mean(normalised)),
                "predictions": len(error),
            }
    return found

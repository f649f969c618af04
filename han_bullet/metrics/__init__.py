"""The figures of a run: one module per subject, each with its tally and its metrics' only definitions."""

from han_bullet.metrics.run_metrics import DEFINITIONS, GROUPS, TALLIES, Metric, Metrics, written
from han_bullet.metrics.tally import Definition, Value

__all__ = ["DEFINITIONS", "GROUPS", "TALLIES", "Definition", "Metric", "Metrics", "Value", "written"]

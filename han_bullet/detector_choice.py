"""Which detector to load, as a value that travels to worker processes."""

from __future__ import annotations

from dataclasses import dataclass

from han_bullet.detection.loading import LoadedDetector, load_detector
from han_bullet.detection.model_files import DEFAULT
from han_bullet.detection.threads import use_one_thread


@dataclass(frozen=True)
class DetectorChoice:
    """Which detector to load; small and picklable, since every worker loads its own.

    Attributes:
        name: As `load_detector` takes it.
        threshold: Least score; None takes the model's own.
        classifier: The CNN, as `load_detector` takes it.
    """

    name: str = DEFAULT
    threshold: float | None = None
    classifier: str = DEFAULT

    def load(self) -> LoadedDetector:
        """Return the detector, for a process that uses one thread."""
        use_one_thread()  # before a network is made ready: with two threads, that takes six times as long
        return load_detector(self.name, self.threshold, self.classifier)

"""Whether one camera works: what its pictures look like, whether they come, and whether it looks where it should."""

from __future__ import annotations

import math
from collections.abc import Sequence

from han_bullet.health.alignment import Alignment
from han_bullet.health.arrivals import Arrivals
from han_bullet.health.watch import Watch
from han_bullet.messages import Fault, FrameDetections, ImageHealth, Seat

# A picture darker and flatter than this shows nothing: noise alone, of 6 grey levels, has a mean of 2.4.
DARK, FLAT = 10.0, 5.0  # [grey levels]
MOVED_FOR = 1.0  # [s] for which the scene has moved in the image: the camera hangs otherwise, nobody just leaned on it


class CameraHealth:
    """Watch one camera.

    A picture that is frozen, black or of a moved scene is of no use from the first one on; the fault that this is shows
    a little later, and its end later still.

    Args:
        camera: Name.
        period: Between its frames [s].
        noisy: Whether its images have noise, so that no two are alike.
        seats: Where people may sit.

    Attributes:
        alignment: Where it looks, if it is on the robot; nobody compares a fixed camera.
    """

    def __init__(self, camera: str, period: float, *, noisy: bool = True, seats: Sequence[Seat] = ()) -> None:
        self.alignment = Alignment(camera, seats)
        self._noisy = noisy
        self._arrivals = Arrivals(period)
        self._last: ImageHealth | None = None
        self._pictures = {kind: Watch(camera, kind) for kind in ("frozen", "black")}
        self._pictures["knocked"] = Watch(camera, "knocked", MOVED_FOR)
        self._delivery = {kind: Watch(camera, kind) for kind in ("dropped", "late")}

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Return what is wrong now."""
        watched = [watch.fault for watch in (*self._pictures.values(), *self._delivery.values())]
        return tuple(fault for fault in (*watched, self.alignment.fault) if fault is not None)

    def take(self, found: FrameDetections, time: float) -> bool:
        """Take in a frame that arrives at a time [s]; tell whether its picture is of use."""
        self._arrivals.note(found.time, time)
        symptoms = self._symptoms(found.health) if found.health is not None else ()
        for kind, watch in self._pictures.items():
            watch.update(kind in symptoms, time)
        self._last = found.health
        return not symptoms and all(watch.fault is None for watch in self._pictures.values())

    def close_tick(self, time: float) -> None:
        """Look for what has not come by a time [s], after the frames of that tick."""
        self.alignment.close_tick(time)
        self._delivery["dropped"].update(self._arrivals.silent(time) or self._arrivals.lossy, time)
        self._delivery["late"].update(self._arrivals.late and not self._arrivals.silent(time), time)

    def _symptoms(self, now: ImageHealth) -> Sequence[str]:
        """Return what is wrong with a picture; of a black one nothing else can be told."""
        if now.brightness < DARK and now.contrast < FLAT:
            return ("black",)
        frozen = self._noisy and self._last is not None and self._last.checksum == now.checksum
        moved = math.hypot(*now.shift) > 0.0
        return [kind for kind, shows in (("frozen", frozen), ("knocked", moved)) if shows]

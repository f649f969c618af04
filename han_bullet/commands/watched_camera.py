"""A camera of this machine that is watched until Ctrl-C."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import closing

from han_bullet.detection.pictures import Image
from han_bullet.image_sources import Video


class WatchedCamera(Video):
    """A camera whose images end with Ctrl-C, as those of a video end; a second Ctrl-C stops the program."""

    def images(self) -> Iterator[tuple[str, Image]]:
        """Give image after image until Ctrl-C, the one that is being looked at included."""
        stopped = False
        before = signal.getsignal(signal.SIGINT)

        def stop(number: int, frame: object) -> None:
            nonlocal stopped
            stopped = True
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, stop)
        try:
            with closing(super().images()) as images:  # type: ignore[type-var]
                for image in images:
                    yield image
                    if stopped:
                        return
        finally:
            signal.signal(signal.SIGINT, before)

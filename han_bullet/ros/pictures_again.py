"""The pictures of a recorded run, taken again: a run's folder keeps none."""

from __future__ import annotations

from types import TracebackType

from han_bullet.detection.image_health import image_health
from han_bullet.errors import BadInputError, HanError
from han_bullet.explain.recorded_run import RecordedRun
from han_bullet.explain.recorded_tables import FrameRow
from han_bullet.messages import CameraImage, Observation
from han_bullet.sim.renderer import InProcessRenderer
from han_bullet.sim.simulator import Simulator
from han_bullet.stack import Decision


class PicturesAgain:
    """The simulator, driven over again by a run's commands, whose cameras take the pictures that they took then.

    Each is held against the checksum that the run has of it, so what is returned is what the robot saw.

    Args:
        run: Of the simulator, with cameras.

    Raises:
        BadInputError: The run had no cameras.
    """

    def __init__(self, run: RecordedRun) -> None:
        if not run.sees:
            raise BadInputError(f"run {str(run.folder)!r} had no cameras (perception truth), so it has no images")
        self._run = run
        self._renderer = InProcessRenderer(run.world, run.result.seed)
        self._simulator = Simulator(run.world, renderer=self._renderer, seed=run.result.seed)
        self._seen: Observation | None = None

    def after(self, decision: Decision | None) -> tuple[CameraImage, ...]:
        """Return the pictures that arrive at the tick after a decision, whose command is carried out.

        Args:
            decision: Of the tick before; None begins.

        Raises:
            HanError: A picture is not the one of the run.
        """
        if decision is None:
            seen = self._simulator.reset()
        else:
            self._simulator.request_hand_over(decision.asks_for_hand_over)
            self._simulator.request_way(decision.asks_to_make_way)
            seen = self._simulator.step(decision.command)
        self._check(seen)
        return seen.images

    def close(self) -> None:
        """Close the simulator."""
        self._simulator.close()
        self._renderer.close()

    def __enter__(self) -> PicturesAgain:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def _check(self, seen: Observation) -> None:
        rows = self._run.frames.get(self._run.tick_at(seen.time), ())
        if len(rows) == len(seen.images) and all(map(_is_of, seen.images, rows)):
            return
        raise HanError(
            f"the simulator does not take the pictures of {str(self._run.folder)!r} again: those of {seen.time:.2f} s "
            f"differ. The run was made by commit {self._run.result.git_commit}; that one can, and without images the "
            "run can be exported as it is"
        )


def _is_of(image: CameraImage, row: FrameRow) -> bool:
    """Tell whether a picture is the one of a line of frames.csv."""
    if (image.camera, round(image.time, 6)) != (row.camera, row.exposed):
        return False
    return row.health is None or image_health(image.image).checksum == row.health.checksum

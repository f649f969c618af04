"""What it would cost to show the CNN every window of an image instead of ACF's proposals: the paper's appendix B.

The paper's search has one scale: windows of the network's input, 64 x 64 px, every 4 px in an image of 480 x 640 px,
105 rows and 145 columns of them. It multiplies the time per window by 105 + 145; a search of the whole image has
105 x 145. Both are shown, and the same of our network, whose input may have another size.

Usage: python -m benchmarks.exhaustive_cnn [--model NAME|FILE] [--classifier NAME|FILE] [--seconds 120]
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.provenance import provenance
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.stages import Stages, load_stages
from han_bullet.detection.threads import use_one_thread
from han_bullet.markdown import markdown_table
from han_bullet.rendered_sequences import corridor

STRIDE = 4  # [px]
PAPER_ROWS, PAPER_COLUMNS = 105, 145
PAPER_SECONDS = 0.0323  # per window; elsewhere the paper has 0.0485
REPETITIONS = 15  # of ACF + CNN, of which the median counts


@dataclass(frozen=True)
class Search:
    """How long a search took.

    Attributes:
        rows, columns: Of windows in the image.
        measured: How many windows the network saw.
        seconds: For these.
    """

    rows: int
    columns: int
    measured: int
    seconds: float

    @property
    def seconds_per_window(self) -> float:
        """Return the time per window."""
        return self.seconds / self.measured


def search(classifier: Classifier, image: NDArray[np.uint8], most_seconds: float) -> Search:
    """Show a classifier the windows of an image, (h, w, 3), a row of them at a time, or as many as the time allows."""
    windows = np.lib.stride_tricks.sliding_window_view(image, classifier.size, axis=(0, 1))[::STRIDE, ::STRIDE]
    windows = windows.transpose(0, 1, 3, 4, 2)  # colours last
    rows, columns = windows.shape[:2]
    classifier.probabilities_of_crops(windows[0])  # not timed: the first call prepares the network
    measured, seconds = 0, 0.0
    for row in np.random.default_rng(0).permutation(rows):  # so that a part of them stands for the whole image
        started = time.perf_counter()
        classifier.probabilities_of_crops(windows[row])
        seconds += time.perf_counter() - started
        measured += columns
        if seconds > most_seconds:
            break
    return Search(rows, columns, measured, seconds)


def both_stages(stages: Stages, image: NDArray[np.uint8]) -> tuple[int, float]:
    """Return the number of proposals and the median time [s] of ACF, threshold and CNN on an image, at all scales."""
    times = []
    for _ in range(REPETITIONS + 1):
        started = time.perf_counter()
        found = stages.propose(image)
        boxes = found.boxes[found.scores >= (-np.inf if stages.threshold is None else stages.threshold)]
        if stages.classifier is not None:
            stages.classifier.probabilities(image, boxes)
        times.append(time.perf_counter() - started)
    return len(boxes), float(np.median(times[1:]))  # the first call loads compiled code


def lines(found: Search, proposals: int, seconds: float) -> list[tuple[str, int, float, float]]:
    """Return the table: search, windows, seconds per image, images per second."""
    few, many = found.rows + found.columns, found.rows * found.columns
    paper_few, paper_many = PAPER_ROWS + PAPER_COLUMNS, PAPER_ROWS * PAPER_COLUMNS
    each = found.seconds_per_window
    searches = [
        (f"the paper, {PAPER_ROWS} + {PAPER_COLUMNS}, {PAPER_SECONDS} s each", paper_few, paper_few * PAPER_SECONDS),
        (f"the paper's time, {PAPER_ROWS} x {PAPER_COLUMNS} windows", paper_many, paper_many * PAPER_SECONDS),
        (f"ours, {found.rows} + {found.columns} windows", few, few * each),
        (f"ours, {found.rows} x {found.columns} windows", many, many * each),
        ("ours, ACF + CNN, all scales", proposals, seconds),
    ]
    return [(name, windows, taken, 1.0 / taken) for name, windows, taken in searches]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--model", default="default")
    parser.add_argument("--classifier", default="default")
    parser.add_argument("--seconds", type=float, default=120.0, help="after which the search is extrapolated")
    options = parser.parse_args()
    use_one_thread()
    (stages,) = load_stages([options.model], options.classifier)
    assert stages.classifier is not None
    image = next(corridor(1, seed=0)).image
    proposals, seconds = both_stages(stages, image)
    found = search(stages.classifier, image, options.seconds)
    print(f"### Exhaustive search with the CNN ({options.classifier}), one scale, one thread\n\n{provenance()}\n")
    print(
        markdown_table(
            ("search", "windows", "seconds per image", "images per second"), lines(found, proposals, seconds)
        )
    )
    share = found.measured / (found.rows * found.columns)
    how = "every window was shown" if share == 1.0 else f"extrapolated from {found.measured} windows, {share:.0%}"
    print(f"\n{1e3 * found.seconds_per_window:.2f} ms per window in batches of {found.columns}; {how}")


if __name__ == "__main__":
    main()

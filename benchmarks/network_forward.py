"""How long a forward pass of each network of the second stage takes, beside the paper's [Mateus2019].

Usage: python -m benchmarks.network_forward [--rounds 20]

Weights are drawn at random: the time does not depend on them. All networks take turns in one run, five proposals at a
time, in one thread. The paper says neither its machine nor how many proposals it takes at a time.
"""

import argparse
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.provenance import provenance
from han_bullet.detection.cnn import Classifier
from han_bullet.detection.network import CropNetwork
from han_bullet.detection.squeezenet import SqueezeTrunk
from han_bullet.detection.threads import use_one_thread
from han_bullet.detection.vgg import SmallVgg, VggD
from han_bullet.markdown import markdown_table

PROPOSALS = 5
# Passes of a network in its turn: the first bring back into the caches what the other networks drove out, as nothing
# does between the frames of a run.
WARMING, TIMED = 3, 3
PAPER = {("vgg-d", 64): 0.0485, ("vgg-d", 224): 0.3619}  # [s], by network and height


def networks() -> list[tuple[str, CropNetwork]]:
    """Return what is compared, with its name."""
    return [("squeezenet", SqueezeTrunk()), ("small", SmallVgg()), ("vgg-d", VggD()), ("vgg-d", VggD(224, 224))]


def forward_times(candidates: Sequence[CropNetwork], rounds: int) -> list[list[float]]:
    """Return for each network the times per proposal of all rounds [s], crops already cut."""
    generator = np.random.default_rng(0)
    classifiers = [Classifier(network) for network in candidates]
    crops = [generator.integers(0, 256, (PROPOSALS, *one.size, 3), np.uint8) for one in classifiers]
    times: list[list[float]] = [[] for _ in classifiers]
    for _ in range(rounds):
        for classifier, batch, taken in zip(classifiers, crops, times, strict=True):
            for number in range(WARMING + TIMED):
                started = time.perf_counter()
                classifier.probabilities_of_crops(batch)
                if number >= WARMING:
                    taken.append((time.perf_counter() - started) / PROPOSALS)
    return times


def rows(candidates: Sequence[tuple[str, CropNetwork]], times: Sequence[Sequence[float]]) -> list[tuple[object, ...]]:
    """Return the lines of the table."""
    lines: list[tuple[object, ...]] = []
    for (name, network), taken in zip(candidates, times, strict=True):
        weights = sum(weight.numel() for weight in network.parameters()) / 1e6
        paper = PAPER.get((name, network.height))
        size = f"{network.height} x {network.width}"
        median, least = 1e3 * float(np.median(taken)), 1e3 * min(taken)
        lines.append((name, size, f"{weights:.1f}", median, least, "-" if paper is None else 1e3 * paper))
    return lines


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=20)
    options = parser.parse_args()
    use_one_thread()
    candidates = networks()
    times = forward_times([network for _, network in candidates], options.rounds)
    print("### Forward pass of the second stage's networks\n")
    print(f"{provenance()}; one thread, {PROPOSALS} proposals at a time, random weights, {options.rounds} rounds\n")
    header = ("network", "input [px]", "weights [million]", "median [ms per proposal]", "minimum [ms per proposal]")
    print(markdown_table((*header, "the paper [ms]"), rows(candidates, times)))
    small, large = (np.array(taken) for taken in times[-2:])
    ratio = PAPER["vgg-d", 224] / PAPER["vgg-d", 64]
    print(f"\nvgg-d takes {np.median(large / small):.1f} times as long at 224 x 224 (the paper: {ratio:.1f} times)")


if __name__ == "__main__":
    main()

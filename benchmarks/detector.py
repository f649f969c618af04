"""How long detectors take on one image, and where the time of ours goes.

Usage: python -m benchmarks.detector [--image FILE] [--repeats 30] [--data DIR]

All detectors take turns in one run, so that ratios hold whatever else the machine does. The original detector is not
here: elsewhere it was measured at 3.15 times HOG's speed, so its time is HOG's divided by 3.15. Ours runs on one thread
by design, in both tables.
"""

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from benchmarks.provenance import provenance
from benchmarks.stopwatch import Stopwatch
from han_bullet.detection import acf, pyramid
from han_bullet.detection.hog_detector import HogDetector
from han_bullet.detection.loading import load_detector
from han_bullet.detection.pedestrian_detector import PedestrianDetector
from han_bullet.detection.pictures import Image, read_picture
from han_bullet.detection.threads import use_one_thread
from han_bullet.markdown import markdown_table

ORIGINAL_TO_HOG = 3.15  # how many times faster the original is than HOG
NOTE = " for OpenCV; ours stays on one, so that results do not depend on their number"
CNN = "CNN"
STAGES = (
    (pyramid, "luv", "LUV"),
    (pyramid, "resample_planes", "resample image"),
    (pyramid, "compute_channels", "channels"),
    (pyramid, "resample", "resample channels"),
    (pyramid, "smooth_and_pad", "smooth and pad"),
    (acf, "scan", "cascade"),
    (acf, "suppress", "suppression"),
)
PEERS = {"FastestDet": "FastestDet.onnx", "Yolo-Fastest-body": "yolo-fastest-1.1_body.cfg"}


def detectors(data: Path | None) -> dict[str, Callable[[Image], object]]:
    """Return what is compared; the networks only where their files are."""
    ours = load_detector()
    found = {"ours: ACF": load_detector(classifier=None).detect, "ours: ACF + CNN": ours.detect}
    found["OpenCV HOG"] = HogDetector().detect
    for name, file in PEERS.items():
        if data is not None and (data / "peers" / file).is_file():
            found[name] = load_detector(data / "peers" / file).detect
        else:
            print(f"{name} is left out: HAN_DATA or --data names no folder with peers/{file}.\n")
    return found


def compare(candidates: dict[str, Callable[[Image], object]], image: Image, repeats: int, threads: int) -> str:
    """Return the table of all detectors with a number of threads for OpenCV."""
    cv2.setNumThreads(threads)
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for repeat in range(repeats + 1):
        for name, detect in candidates.items():
            started = time.perf_counter()
            detect(image)
            if repeat:  # the first loads compiled code
                times[name].append(1e3 * (time.perf_counter() - started))
    cv2.setNumThreads(1)
    hog = np.array(times["OpenCV HOG"])
    rows = []
    for name, taken in times.items():
        ratio = float(np.median(hog / np.array(taken)))
        rows.append((name, float(np.median(taken)), min(taken), ratio, ratio / ORIGINAL_TO_HOG))
    return markdown_table(("detector", "median [ms]", "minimum [ms]", "speed : HOG", "speed : original"), rows)


def breakdown(image: Image, repeats: int) -> str:
    """Return where the time of ours goes, per image; of the CNN also per proposal."""
    ours = load_detector()
    assert isinstance(ours, PedestrianDetector) and ours.classifier is not None
    ours.detect(image)  # compiled code loaded
    proposals = len(ours.propose(image).boxes)
    watch = Stopwatch()
    for owner, name, stage in STAGES:
        watch.watch(owner, name, stage)
    watch.watch(ours.classifier, "probabilities", CNN)
    watch.watch(ours, "detect", "all")
    counts = []
    for _ in range(repeats):
        before = {name: len(times) for name, times in watch.times.items()}
        ours.detect(image)
        counts.append({name: sum(times[before.get(name, 0) :]) for name, times in watch.times.items()})
    watch.restore()
    rows = [(name, 1e3 * float(np.median([count[name] for count in counts]))) for name in counts[0]]
    whole = dict(rows)["all"]
    shown = [(name, taken, f"{taken / whole:.0%}") for name, taken in rows]
    rest = whole - sum(taken for name, taken in rows if name != "all")
    shown.insert(-1, ("the rest: boxes, pyramid's lists, this stopwatch", rest, f"{rest / whole:.0%}"))
    if proposals:
        shown.append((f"CNN, per proposal of {proposals}", dict(rows)[CNN] / proposals, ""))
    return markdown_table(("stage of ours", "median [ms]", "share"), shown)


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--image", type=Path, help="picture (default: reference/acf/photo.png beside the data folder)")
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--data", type=Path, default=os.environ.get("HAN_DATA") or None, help="default: HAN_DATA")
    options = parser.parse_args()
    data = Path(options.data) if options.data else None
    file = options.image or (data.parent / "reference" / "acf" / "photo.png" if data else None)
    print("### Detectors side by side on one image\n")
    if file is None or not file.is_file():
        print("Left out: there is no picture; set HAN_DATA or give --image.")
        return
    use_one_thread()
    image = read_picture(file)
    print(f"{provenance()}; {file.name}, {image.shape[1]} x {image.shape[0]} px, {options.repeats} rounds\n")
    candidates = detectors(data)
    for threads in (1, 2):
        print(f"{threads} thread{'s' if threads > 1 else ''}{NOTE if threads > 1 else ''}:\n")
        print(compare(candidates, image, options.repeats, threads) + "\n")
    print(breakdown(image, options.repeats))


if __name__ == "__main__":
    main()

"""How many threads the libraries under the detector may use."""

import cv2


def use_one_thread() -> None:
    """Keep OpenCV and torch to one thread in this process.

    Camera processes share the cores already, and a network's float sums depend in their last bits on the number of
    threads: one thread everywhere is what makes a result independent of the number of processes.
    """
    import torch  # 200 MB; a process that only drives worker processes never needs it

    cv2.setNumThreads(1)
    if torch.get_num_threads() != 1:
        torch.set_num_threads(1)

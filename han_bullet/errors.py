"""The errors that han_bullet raises on purpose: one base class, so that a caller can catch them all.

And the checks that constructors make of the numbers they are given.
"""

import math


class HanError(Exception):
    """Base of every error that han_bullet raises; the message names the value and what would be right."""


class BadInputError(HanError):
    """Something a person gave (world file, option, image, weights) cannot be used; exit code 2."""


class WorkerDiedError(HanError):
    """A process that the work is shared with is gone before it was done; exit code 3.

    That is a worker of cameras or detection, the scheduler of a sweep's cluster, or the ROS node.
    """


def check_positive(what: str, **values: float) -> None:
    """Raise BadInputError for the first parameter of something that is not a positive finite number."""
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise BadInputError(f"{what}: {name} is {value!r}; it must be a positive number")


def check_not_negative(what: str, **values: float) -> None:
    """Raise BadInputError for the first parameter of something that is negative or not finite."""
    for name, value in values.items():
        if not 0.0 <= value < math.inf:
            raise BadInputError(f"{what}: {name} is {value!r}; it must be 0 or a positive number")


LONGEST_QUOTE = 200  # characters


def quoted(error: Exception) -> str:
    """Return what another library's error says, in one line and not too long, to quote in a sentence of ours."""
    return (" ".join(str(error).split()) or type(error).__name__)[:LONGEST_QUOTE]

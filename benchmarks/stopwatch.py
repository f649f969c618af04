"""Wall-clock times of calls, by replacing what is called."""

import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any


class Stopwatch:
    """Wall-clock times by label [s]."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = defaultdict(list)
        self._replaced: list[tuple[Any, str, Any]] = []

    def watch(self, owner: Any, method: str, label: Callable[..., str] | str) -> None:
        """Replace a method of an object by one that notes how long each call takes."""
        original = getattr(owner, method)
        self._replaced.append((owner, method, original))

        def timed(*arguments: Any, **keywords: Any) -> Any:
            started = time.perf_counter()
            result = original(*arguments, **keywords)
            name = label if isinstance(label, str) else label(*arguments)
            self.times[name].append(time.perf_counter() - started)
            return result

        setattr(owner, method, timed)

    def restore(self) -> None:
        """Put back what was replaced."""
        for owner, method, original in reversed(self._replaced):
            setattr(owner, method, original)
        self._replaced.clear()

"""What is loaded before the first tick, asked of a process of its own: this one has used everything already."""

import subprocess
import sys
from pathlib import Path

import pytest

# Prints what of the compiled code a run needed in its loop that was not there before its first tick.
PROGRAM = """
import sys
from pathlib import Path

from numba.core.dispatcher import Dispatcher

from han_bullet.episode import Hook
from han_bullet.runner import RunOptions, run_world


def loaded():
    modules = [(name, module) for name, module in sys.modules.items() if name.startswith("han_bullet")]
    functions = [(name, value) for name, module in modules for value in vars(module).values()]
    return {
        f"{name}.{value.__name__}{signature}"
        for name, value in functions
        if isinstance(value, Dispatcher) and value.__module__ == name
        for signature in value.signatures
    }


class Watch(Hook):
    before = None

    def observe(self, observation):
        self.before = self.before or loaded()

    def record(self, tick):
        self.late = loaded() - self.before


watch = Watch()
world, perception, folder = sys.argv[1:]
run_world(world, RunOptions(perception=perception, workers=1, video=False), Path(folder), hooks=[watch])
assert watch.before
print("\\n".join(sorted(watch.late)))
"""


@pytest.mark.parametrize(("perception", "duration"), [("cameras", 2.0), ("truth", 6.0)])
def test_the_loop_compiles_nothing(perception: str, duration: float, tmp_path: Path) -> None:
    world = tmp_path / "brief.yaml"
    world.write_text(f"extends: real2\nduration: {duration}\n")
    arguments = [sys.executable, "-c", PROGRAM, str(world), perception, str(tmp_path / "run")]
    printed = subprocess.run(arguments, check=True, capture_output=True, text=True).stdout
    assert printed.split() == []

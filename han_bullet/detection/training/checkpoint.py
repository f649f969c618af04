"""The state of an interrupted training, in a file that can hold nothing but tensors, numbers and text."""

from __future__ import annotations

import io
from pathlib import Path

import torch
from torch import nn

from han_bullet.atomic_file import write_at_once
from han_bullet.detection.tensor_file import read_tensors
from han_bullet.errors import BadInputError, quoted


def checkpoint_file(out: Path) -> Path:
    """Return where the checkpoint of a training lies that writes its weights to `out`."""
    return out.with_name(f"{out.name}.checkpoint")


def require_checkpoint(out: Path) -> None:
    """Make sure that there is something to resume, before anything else takes time.

    Raises:
        BadInputError: There is no checkpoint.
    """
    if not checkpoint_file(out).is_file():
        raise BadInputError(f"no checkpoint {checkpoint_file(out)} to resume from; train without --resume")


class Checkpoint:
    """A network and its optimizer after a number of epochs.

    Args:
        out: File of the weights, beside which the checkpoint lies.
        settings: Everything that decides what the training does; only an equal one can be resumed.
    """

    def __init__(self, out: Path, settings: str) -> None:
        self.path, self.settings = checkpoint_file(out), settings

    def store(self, network: nn.Module, optimizer: torch.optim.Optimizer, epochs: int) -> None:
        """Write the state after so many epochs, at once."""
        buffer = io.BytesIO()
        state = {"settings": self.settings, "epochs": epochs, "network": network.state_dict()}
        torch.save(state | {"optimizer": optimizer.state_dict()}, buffer)
        write_at_once(self.path, buffer.getvalue())

    def restore(self, network: nn.Module, optimizer: torch.optim.Optimizer) -> int:
        """Load the state and return the number of epochs that are done.

        Raises:
            BadInputError: There is no such file, it is damaged, or it is of a training with other settings.
        """
        state = read_tensors(self.path)
        settings = state.get("settings")
        if settings != self.settings:
            raise BadInputError(f"checkpoint {self.path} is of another training ({settings}), not of {self.settings}")
        try:
            network.load_state_dict(state["network"])
            optimizer.load_state_dict(state["optimizer"])
            return int(state["epochs"])
        except (KeyError, TypeError, ValueError, RuntimeError, AttributeError) as error:
            raise BadInputError(f"checkpoint {self.path} is damaged: {quoted(error)}") from error

    def remove(self) -> None:
        """Delete the file of a training that is complete."""
        self.path.unlink(missing_ok=True)

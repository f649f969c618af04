"""The state of an interrupted training, in a file that can hold nothing but numbers."""

from __future__ import annotations

import io
from pathlib import Path

import torch
from torch import nn

from han_bullet.atomic_file import write_at_once
from han_bullet.errors import BadInputError


class Checkpoint:
    """A network and its optimizer after a number of epochs.

    Args:
        path: File to write.
        settings: Everything that decides what the training does; only an equal one can be resumed.
    """

    def __init__(self, path: Path, settings: str) -> None:
        self.path, self.settings = path, settings

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
        if not self.path.is_file():
            raise BadInputError(f"no checkpoint {self.path} to resume from; train without --resume")
        try:
            state = torch.load(self.path, weights_only=True)
            settings, epochs = str(state["settings"]), int(state["epochs"])
        except Exception as error:  # torch raises pickle's own errors for a damaged file
            raise BadInputError(f"checkpoint {self.path} is damaged: {' '.join(str(error).split())[:200]}") from error
        if settings != self.settings:
            raise BadInputError(f"checkpoint {self.path} is of another training ({settings}), not of {self.settings}")
        network.load_state_dict(state["network"])
        optimizer.load_state_dict(state["optimizer"])
        return epochs

    def remove(self) -> None:
        """Delete the file of a training that is complete."""
        self.path.unlink(missing_ok=True)

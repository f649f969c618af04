"""Files of tensors, read so that nothing is unpickled but tensors, numbers and text."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file

from han_bullet.errors import BadInputError, quoted


def read_tensors(path: Path) -> Mapping[str, Any]:
    """Return what a .safetensors file, or one that `torch.save` wrote, holds under each name.

    Raises:
        BadInputError: The file is missing or damaged, holds anything but tensors, numbers and text, or has no names.
    """
    try:
        if path.suffix == ".safetensors":
            tensors: Mapping[str, Any] = load_file(path)
            return tensors
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about what is refused a moment later
            content = torch.load(path, map_location="cpu", weights_only=True)
    except (OSError, SafetensorError, RuntimeError) as error:
        raise BadInputError(f"{path} cannot be read as a file of tensors: {quoted(error)}") from error
    except Exception as error:  # torch raises pickle's own errors, and others, for what it refuses to unpickle
        raise BadInputError(f"{path} is refused: it is damaged or holds other things than tensors") from error
    if not isinstance(content, Mapping):
        raise BadInputError(f"{path} holds a {type(content).__name__}; tensors with names would be right")
    return content

"""The detectors' names and the files of their weights: how they are told apart and found."""

from __future__ import annotations

from pathlib import Path

from han_bullet import assets
from han_bullet.errors import BadInputError

DEFAULT = "default"
DEFAULT_PROPOSER = "acf_inria"
DEFAULT_CLASSIFIER = "cnn_inria"
HOG = "hog"  # OpenCV's people detector, which needs no file
NETWORK_ENDINGS = (".onnx", ".cfg")  # of networks that find people by themselves


def is_hog(name_or_path: str | Path) -> bool:
    """Tell whether OpenCV's people detector is meant."""
    return str(name_or_path) == HOG


def is_network(name_or_path: str | Path) -> bool:
    """Tell whether a model is a network that finds people by itself."""
    return Path(name_or_path).suffix.lower() in NETWORK_ENDINGS


def has_one_stage(name_or_path: str | Path) -> bool:
    """Tell whether a model needs neither ACF nor the CNN."""
    return is_hog(name_or_path) or is_network(name_or_path)


def model_name(name_or_path: str | Path) -> str:
    """Return what results call a model: its file's name without ending, or "hog".

    Raises:
        BadInputError: There is no such model.
    """
    return HOG if is_hog(name_or_path) else proposer_file(name_or_path).stem


def is_shipped_proposer(name_or_path: str | Path) -> bool:
    """Tell whether a model is the ACF model that is shipped: by default, by its name, or by its file.

    Raises:
        BadInputError: There is no such model.
    """
    return not is_hog(name_or_path) and proposer_file(name_or_path).resolve() == proposer_file().resolve()


def proposer_file(name_or_path: str | Path = DEFAULT) -> Path:
    """Return the file of an ACF model or of a network: "default", the name of a shipped one, or the path of a file.

    Raises:
        BadInputError: There is no such model.
    """
    return _find(name_or_path, DEFAULT_PROPOSER, ".npz")


def classifier_file(name_or_path: str | Path = DEFAULT) -> Path:
    """Return the file of a CNN: "default", the name of a shipped one, or the path of a file.

    Raises:
        BadInputError: There is no such model.
    """
    return _find(name_or_path, DEFAULT_CLASSIFIER, ".safetensors")


def _find(name_or_path: str | Path, default: str, ending: str) -> Path:
    shipped = {path.stem: path for path in sorted(assets.models_folder().glob(f"*{ending}"))}
    name = default if str(name_or_path) == DEFAULT else str(name_or_path)
    path = shipped.get(name, Path(name_or_path))
    if not path.is_file():
        raise BadInputError(
            f"model {str(name_or_path)!r} is neither a file nor one of the shipped: {', '.join(shipped) or 'none'}"
        )
    return path

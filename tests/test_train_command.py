"""`han-bullet train` as a person meets it: files, progress, one sentence about what is wrong."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from little_samples import everything_detector, write_pictures

from han_bullet.cli import main
from han_bullet.detection.acf import load_acf_model
from han_bullet.detection.cnn import load_network
from han_bullet.detection.training import acf_training
from han_bullet.detection.vgg import SmallVgg


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with seven little pictures and the model of a first stage that takes all for people."""
    folder = write_pictures(tmp_path_factory.mktemp("data"))
    everything_detector().model.save(folder / "everything.npz")
    return folder


def small(data: Path, out: Path, *more: str) -> list[str]:
    """Return the command that trains the small network for an epoch."""
    acf = str(data / "everything.npz")
    arguments = ["train", "cnn", "--data", str(data), "--acf", acf, "--network", "small", "--epochs", "1"]
    return [*arguments, "--out", str(out), *more]


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("han-bullet: ") and captured.err.count("\n") == 1
    assert "Traceback" not in captured.err + captured.out
    return captured.err


def test_a_network_is_trained_and_its_log_and_card_stand_beside_it(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "mine.safetensors"
    assert main(small(data, out, "--seed", "5")) == 0
    shown = capsys.readouterr().out
    assert "epoch 1/1: training loss" in shown and "mine.md" in shown and "mine.log" in shown
    assert {path.name for path in out.parent.iterdir()} == {"mine.safetensors", "mine.log", "mine.md"}
    assert isinstance(load_network(out), SmallVgg)
    log, card = (out.with_suffix(ending).read_text() for ending in (".log", ".md"))
    assert [line.split("  ")[-1].split(":")[0] for line in log.splitlines()] == [
        "8 crops of people, 0 beside them",
        "54 hard negatives",
        "step 1",
        "epoch 1/1",
    ]
    assert log in card and "| seed | 5 |" in card
    assert "`han-bullet evaluate --data DIR --classifier mine.safetensors`" in card


def test_the_same_seed_gives_the_same_file_and_options_change_it(data: Path, tmp_path: Path) -> None:
    kinds = {"a": (), "b": (), "seed": ("--seed", "1"), "recipe": ("--recipe", "extended")}
    kinds |= {"deviation": ("--deviation", "0.1"), "rate": ("--learning-rate", "0.01"), "bf16": ("--bf16",)}
    for name, more in kinds.items():
        assert main(small(data, tmp_path / f"{name}.safetensors", *more)) == 0
    files = {name: (tmp_path / f"{name}.safetensors").read_bytes() for name in kinds}
    assert files.pop("a") == files["b"]
    assert len(set(files.values())) == len(files)


def test_a_cascade_is_trained_and_its_stages_stand_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(0)
    for name, count, size in (("train_pos", 12, (160, 96)), ("train_neg", 3, (170, 200))):
        (tmp_path / "inria" / name).mkdir(parents=True)
        for number in range(count):
            image = cv2.GaussianBlur(rng.integers(0, 256, (*size, 3), dtype=np.uint8), (0, 0), 2.0)
            if name == "train_pos":
                image[32:128, 33:62] = (250, 240, 120)
            assert cv2.imwrite(str(tmp_path / "inria" / name / f"{number:02d}.png"), image)
    monkeypatch.setattr(acf_training, "REPORTED_TREES", 1)  # so that the log has trees, few as there are
    out = tmp_path / "out" / "mine.npz"
    # The little world is told apart by so few trees that discrete boosting ends early in each of its four stages.
    arguments = ["train", "acf", "--data", str(tmp_path), "--boosting", "discrete", "--depth", "2"]
    assert main([*arguments, "--out", str(out)]) == 0
    assert "stage 4: tree 1 " in capsys.readouterr().out
    stages = [f"mine_stage{number}.npz" for number in range(1, 5)]
    assert {path.name for path in out.parent.iterdir()} == {"mine.npz", "mine.log", "mine.md", *stages}
    assert load_acf_model(str(out)).depth == 2
    assert "`han-bullet evaluate --data DIR --model mine.npz`" in out.with_suffix(".md").read_text()
    assert "12 people, lambdas (0.0, " in out.with_suffix(".log").read_text()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["train"], "STAGE"),
        (["train", "cnn"], "--data"),
        (["train", "cnn", "--data", "nowhere", "--network", "small"], "'nowhere' does not exist"),
        (["train", "cnn", "--data", "nowhere"], "'nowhere' does not exist"),
        (["train", "acf", "--data", "nowhere"], "'nowhere' does not exist"),
        (["train", "cnn", "--data", "{empty}", "--network", "small"], "neither inria/ nor INRIAPerson/"),
        (["train", "acf", "--data", "{empty}"], "neither inria/ nor INRIAPerson/"),
        (["train", "cnn", "--data", "{data}"], "compressed_SqueezeNet.net is missing"),
        (["train", "cnn", "--data", "{data}", "--network", "resnet"], "resnet"),
        (["train", "cnn", "--data", "{data}", "--acf", "acf_nowhere"], "acf_nowhere"),
        (["train", "cnn", "--data", "{data}", "--network", "small", "--weights", "x.pth"], "x.pth is of no use to it"),
        (["train", "cnn", "--data", "{data}", "--network", "vgg-d", "--weights", "x.pth"], "x.pth is missing"),
        (["train", "cnn", "--data", "{data}", "--epochs", "0"], "'0' is not a whole number of at least 1"),
        (["train", "cnn", "--data", "{data}", "--learning-rate", "0"], "learning rate 0.0"),
        (["train", "cnn", "--data", "{data}", "--learning-rate", "nan"], "learning rate nan"),
        (["train", "cnn", "--data", "{data}", "--deviation", "-1"], "deviation of the initial weights is -1.0"),
        (["train", "cnn", "--data", "{data}", "--recipe", "soup"], "soup"),
        (["train", "acf", "--data", "{data}", "--depth", "9"], "depth of the trees is 9; 1 to 8 would be right"),
        (["train", "cnn", "--data", "{data}", "--network", "small", "--resume"], "no checkpoint"),
    ],
)
def test_bad_input_is_one_sentence_and_leaves_no_file(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], expected: str
) -> None:
    places = {"data": data, "empty": tmp_path / "empty"}
    places["empty"].mkdir()
    command = [argument.format(**places) for argument in arguments]
    out = tmp_path / ("mine.npz" if command[1:2] == ["acf"] else "mine.safetensors")
    assert expected in complaint(capsys, *command, *(["--out", str(out)] if len(command) > 2 else []))
    assert [path.name for path in tmp_path.iterdir()] == ["empty"]


def test_a_start_that_fails_leaves_no_empty_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "runs" / "train" / "acf.npz")
    assert "does not exist" in complaint(capsys, "train", "acf", "--data", str(tmp_path / "nowhere"), "--out", out)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("folder.safetensors", "is a folder"),
        ("mine.npz", "ends in '.npz'"),
        ("mine", "has no ending"),
        ("mine.md", "ends in '.md'"),
        ("mine.log", "ends in '.log'"),
    ],
)
def test_an_out_that_cannot_hold_the_weights_is_refused_by_name(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, what: str
) -> None:
    (tmp_path / "folder.safetensors").mkdir()
    message = complaint(capsys, *small(data, tmp_path / name))
    assert f"{name}' {what}; " in message and "a file for the weights, .safetensors, would be right" in message


def test_an_out_below_a_file_is_refused_by_name(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert "file" in complaint(capsys, *small(data, tmp_path / "file" / "mine.safetensors"))


def test_a_failed_start_leaves_weights_log_and_card_of_an_earlier_training_alone(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mine.safetensors"
    assert main(small(data, out)) == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    capsys.readouterr()
    complaint(capsys, *small(data / "nowhere", out)[:4], "--network", "small", "--out", str(out))
    complaint(capsys, *small(data, out, "--resume"))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_an_interrupted_training_is_resumed_and_gives_the_same_file(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, out = tmp_path / "whole.safetensors", tmp_path / "mine.safetensors"
    more = ("--epochs", "3", "--recipe", "extended")
    assert main(small(data, whole, *more)) == 0
    from han_bullet.detection.training import cnn_training

    run_epoch = cnn_training._run_epoch

    def interrupted(*arguments: object) -> float:
        if arguments[3] == 2:
            raise KeyboardInterrupt
        return run_epoch(*arguments)

    out.with_suffix(".md").write_text("of earlier weights")
    monkeypatch.setattr(cnn_training, "_run_epoch", interrupted)
    assert main(small(data, out, *more)) == 130
    monkeypatch.undo()
    assert (tmp_path / "mine.safetensors.checkpoint").is_file()
    assert out.is_file() and not out.with_suffix(".md").exists()  # no card but that of these weights
    assert main(small(data, out, *more, "--resume")) == 0
    assert out.read_bytes() == whole.read_bytes()
    assert not (tmp_path / "mine.safetensors.checkpoint").exists()
    log = (tmp_path / "mine.log").read_text()
    assert [f"epoch {number}/3" in log for number in (1, 2, 3)] == [True] * 3
    assert "since it was resumed" in (tmp_path / "mine.md").read_text()


@pytest.mark.data
def test_the_default_network_starts_from_the_imagenet_weights_of_the_data_folder(
    data: Path, data_folder: Path, tmp_path: Path
) -> None:
    photographs = tmp_path / "data"
    photographs.mkdir()
    (photographs / "inria").symlink_to(data / "inria")
    (photographs / "squeezenet").symlink_to(data_folder / "squeezenet")
    arguments = ["--data", str(photographs), "--acf", str(data / "everything.npz"), "--epochs", "1"]
    assert main(["train", "cnn", *arguments, "--out", str(tmp_path / "mine.safetensors")]) == 0
    network = load_network(tmp_path / "mine.safetensors")
    assert (network.height, network.width) == (112, 56)
    state = network.state_dict()
    assert torch.isfinite(state["features.0.weight"]).all() and state["features.0.weight"].abs().max() > 0.1

"""The benchmark on where people are looked for: its ways look at ever fewer windows and find the same people."""

from benchmarks.ceiling_frames import CHANGED, EVERYWHERE, HEADER, LIMITED, measure
from han_bullet.rendered_sequences import corridor, mbot

WINDOWS, RECALL = len(HEADER), len(HEADER) + 1


def test_ceiling_cameras_find_the_same_people_in_ever_fewer_windows() -> None:
    frames = list(corridor(12, 0))[9:]
    assert all(len(frame.boxes) for frame in frames)
    lines = measure("corridor", iter(frames))
    assert [line[1] for line in lines] == [EVERYWHERE, LIMITED, CHANGED]
    assert [line[2] for line in lines] == [3, 3, 3]
    everywhere, limited, changed = (float(str(line[WINDOWS])) for line in lines)
    assert everywhere == 73_888
    assert 0 < changed < 0.5 * limited < 0.5 * everywhere
    assert len({line[RECALL] for line in lines}) == 1


def test_a_camera_that_moves_is_looked_at_in_two_ways() -> None:
    lines = measure("MBOT", mbot(1, 0))
    assert [line[1] for line in lines] == [EVERYWHERE, LIMITED]

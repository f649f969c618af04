"""The tables of a run that pages and explanations both read."""

from pathlib import Path

import numpy as np
import pytest

from han_bullet.errors import BadInputError
from han_bullet.messages import DeviceMessage, Posture
from han_bullet.run_folder import Table, read_table
from han_bullet.run_tables import TrackRow, messages_of, trace_of, tracks_of

ROBOT = "time,robot.x,robot.y,robot.yaw,robot.vx,robot.vy,robot.omega"
TRACE = f"""\
{ROBOT},anna.x,anna.y,anna.yaw,anna.posture,bob.x,bob.y,bob.yaw,bob.posture
0.000000,1.0,2.0,0.1,0.3,0.4,0.5,4.0,6.0,3.0,walking,1.0,2.5,0.0,seated
0.050000,1.1,2.0,0.1,0.0,0.0,0.0,4.1,6.0,3.0,standing,1.0,2.5,0.0,seated
"""


def table(folder: Path, text: str) -> Table:
    path = folder / "table.csv"
    path.write_text(text)
    return read_table(path)


def test_a_trace_has_the_ways_of_robot_and_people(tmp_path: Path) -> None:
    trace = trace_of(table(tmp_path, TRACE))
    np.testing.assert_allclose(trace.time, [0.0, 0.05])
    np.testing.assert_allclose(trace.poses[1], [1.1, 2.0, 0.1])
    np.testing.assert_allclose(trace.twists[0], [0.3, 0.4, 0.5])
    np.testing.assert_allclose(trace.speed, [0.5, 0.0])
    anna, bob = trace.people
    assert (anna.name, anna.postures) == ("anna", (Posture.WALKING, Posture.STANDING))
    np.testing.assert_allclose(anna.poses[1], [4.1, 6.0, 3.0])
    np.testing.assert_allclose(bob.places, [[1.0, 2.5], [1.0, 2.5]])
    np.testing.assert_allclose(trace.distances()[:, 0], [5.0, 0.5])


def test_of_a_trace_those_are_read_who_are_asked_for_and_who_is_missing_is_named(tmp_path: Path) -> None:
    found = table(tmp_path, TRACE)
    assert [person.name for person in trace_of(found, ["bob"]).people] == ["bob"]
    with pytest.raises(BadInputError, match=r"table.csv: has no column 'carl.x'"):
        trace_of(found, ["bob", "carl"])


def test_a_posture_that_nobody_has_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match=r"table.csv: line 3 cannot be read: 'dancing' is not a valid Posture"):
        trace_of(table(tmp_path, TRACE.replace("standing", "dancing")))


def test_tracks_stand_under_the_tick_at_which_they_were_believed(tmp_path: Path) -> None:
    rows = "0.050000,3,1.0,2.0,0.1,0.2\n0.050000,4,5.0,6.0,0.0,0.0\n0.150000,3,1.1,2.0,0.1,0.2\n"
    tracks = tracks_of(table(tmp_path, f"time,id,x,y,vx,vy\n{rows}"))
    assert tracks == {
        1: [TrackRow(3, (1.0, 2.0, 0.1, 0.2)), TrackRow(4, (5.0, 6.0, 0.0, 0.0))],
        3: [TrackRow(3, (1.1, 2.0, 0.1, 0.2))],
    }


def test_messages_stand_under_the_tick_at_which_they_arrived(tmp_path: Path) -> None:
    rows = "0.100000,tv,0.050000,0,simulator\n1.000000,tv,1.000000,1,\n"
    messages = messages_of(table(tmp_path, f"time,device,sent,on,session\n{rows}"))
    assert messages == {
        2: [DeviceMessage("tv", 0.05, on=False, session="simulator")],
        20: [DeviceMessage("tv", 1.0, on=True, session="")],
    }

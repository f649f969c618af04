"""The list of faults that a run's result has."""

from dataclasses import replace

from ticks import tick

from han_bullet.messages import Fault
from han_bullet.noticed_faults import NoticedFaults

FROZEN, LATE, AGAIN = Fault("a", "frozen", 0.05), Fault("b", "late", 0.1), Fault("a", "frozen", 0.2)


def test_faults_are_told_in_the_order_of_their_beginnings_with_their_ends() -> None:
    noticed = NoticedFaults()
    for index, faults in enumerate([(), (FROZEN,), (FROZEN, LATE), (LATE,), (AGAIN, LATE)]):
        one = tick(index)
        noticed.record(replace(one, decision=replace(one.decision, faults=faults)))
    assert [fault.as_json() for fault in noticed.faults] == [
        {"sensor": "a", "kind": "frozen", "from": 0.05, "until": 0.15},
        {"sensor": "b", "kind": "late", "from": 0.1, "until": None},
        {"sensor": "a", "kind": "frozen", "from": 0.2, "until": None},
    ]

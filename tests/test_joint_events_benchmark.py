"""The benchmark of joint events, on few people."""

from benchmarks.joint_events import cluster_rows, room_rows


def test_a_cluster_has_its_events_its_partial_sums_and_whether_all_of_them_were_added_up() -> None:
    two, large = cluster_rows([2, 15], rounds=1)
    assert two[:4] == ("2 x 2", "7.0e+00", 12, "yes")  # nobody; four lone pairs; two of two
    assert large[0] == "15 x 15" and large[2:4] == (16 << 15, "thinned")
    assert float(str(large[4])) > 0.0


def test_a_room_has_a_line_for_each_association_of_all_scans_but_those_that_warm_up() -> None:
    lines = room_rows(seconds=1, seeds=2, people=4)
    assert [line[:2] for line in lines] == [("nnjpda", 20), ("nn", 20), ("gnn", 20)]
    assert all(0.0 < float(str(line[2])) <= float(str(line[3])) for line in lines)
    assert [line[4] for line in lines[1:]] == ["-", "-"]


def test_twenty_people_need_partial_sums_for_nnjpda_alone() -> None:
    nnjpda, nearest, best = room_rows(seconds=2, seeds=1)
    assert int(str(nnjpda[4])) >= 4
    assert (nearest[4], best[4]) == ("-", "-")

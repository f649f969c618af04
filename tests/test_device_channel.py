from han_bullet.device_channel import MOST_WAITING, EmbeddedChannel


def test_what_is_published_inside_the_process_arrives_once_in_order_and_at_once() -> None:
    channel = EmbeddedChannel()
    assert channel.receive() == ()
    channel.publish("tv", b"1")
    channel.publish("radio", b"2")
    assert channel.receive() == (b"1", b"2")
    assert channel.receive() == ()


def test_of_a_flood_the_newest_payloads_are_kept() -> None:
    channel = EmbeddedChannel()
    for number in range(MOST_WAITING + 5):
        channel.publish("tv", b"%d" % number)
    payloads = channel.receive()
    assert len(payloads) == MOST_WAITING and payloads[-1] == b"%d" % (MOST_WAITING + 4)

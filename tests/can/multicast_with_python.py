#!/usr/bin/python3
"""multicast_with_python.py MIRROR: python-can talks to our mirror over udp_multicast, both ways."""

import subprocess
import sys

import can

# Only what hangs takes so long: tests/patience.hpp.
PATIENCE_S = 600

GROUPS = {
    "udp": ("ff15:7079:7468:6f6e:6465:6d6f:6d63:6173", 43113),
    "udp:239.74.163.2": ("239.74.163.2", 43113),
    "udp:[ff15::77]:5000": ("ff15::77", 5000),
}

FRAMES = [
    can.Message(arbitration_id=0x601, data=[0x40, 0, 0x10, 0, 0, 0, 0, 0], is_extended_id=False),
    can.Message(arbitration_id=0x000, data=[1, 0], is_extended_id=False),
    can.Message(arbitration_id=0x080, data=[], is_extended_id=False),
    can.Message(arbitration_id=0x1ABCDEF0, data=[255, 128, 1], is_extended_id=True),
    can.Message(arbitration_id=0x701, is_remote_frame=True, dlc=4, is_extended_id=False),
]


def mirrored(sent, got):
    return (
        got.arbitration_id == sent.arbitration_id + 1
        and got.is_extended_id == sent.is_extended_id
        and got.is_remote_frame == sent.is_remote_frame
        and got.dlc == sent.dlc
        and bytes(got.data) == bytes(sent.data)[::-1]
        and not got.is_error_frame
        and not got.is_fd
    )


def kind(message):
    return message.arbitration_id, message.is_fd, message.is_error_frame


def next_foreign(bus, own):
    """The next frame that is none of its own: python-can hears itself."""
    while (got := bus.recv(PATIENCE_S)) is not None:
        if kind(got) not in map(kind, own):
            return got
    return None


def talk(bus):
    for sent in FRAMES:
        # Neither is answered: CAN FD and error frames are none of classic CAN's. Answers come in the
        # order of the frames, so those would come first.
        own = [
            can.Message(arbitration_id=0x601, is_fd=True, data=bytes(12), is_extended_id=False),
            can.Message(arbitration_id=0x602, is_error_frame=True, is_extended_id=False),
            sent,
        ]
        for message in own:
            bus.send(message)
        got = next_foreign(bus, own)
        assert got is not None, f"no answer to {sent}"
        assert mirrored(sent, got), f"{sent} was answered by {got}"
    bus.send(can.Message(arbitration_id=0x7F0, is_extended_id=False))


# As in host-sim/can/README.md: only what nodes send.
OF_NODES = [
    {"can_id": 0x080, "can_mask": 0x080, "extended": False},
    {"can_id": 0x700, "can_mask": 0x780, "extended": False},
]


def hears_no_echo(group, port, mirror_name):
    """The mirror answers 280h by 281h, a TPDO; 201h and 601h come back as echoes and by 202h, 602h."""
    with can.Bus(
        channel=group, port=port, interface="udp_multicast", fd=False, can_filters=OF_NODES
    ) as bus:
        for identifier in (0x201, 0x601, 0x280):
            bus.send(can.Message(arbitration_id=identifier, data=[6, 0, 1], is_extended_id=False))
        heard = set()
        # The answer to the last frame is the last that comes.
        while 0x281 not in heard:
            got = bus.recv(PATIENCE_S)
            assert got is not None, f"{mirror_name}: the filter keeps what nodes send away"
            heard.add(got.arbitration_id)
        assert not heard & {0x201, 0x202, 0x601, 0x602}, f"{mirror_name}: an echo: {heard}"


def main(mirror):
    for name, (group, port) in GROUPS.items():
        with subprocess.Popen([mirror, name], stdout=subprocess.PIPE) as partner:
            try:
                assert partner.stdout.readline() == b"ready\n", f"{name}: the mirror does not start"
                hears_no_echo(group, port, name)
                with can.Bus(channel=group, port=port, interface="udp_multicast") as bus:
                    talk(bus)
                assert partner.wait(PATIENCE_S) == 0, name
            finally:
                partner.kill()
        print(f"{name}: {len(FRAMES)} frames both ways")


main(sys.argv[1])

#!/usr/bin/python3
"""multicast_with_python.py MIRROR: python-can talks to our mirror over udp_multicast, both ways."""

import subprocess
import sys

import can

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


def next_foreign(bus, sent):
    """The next frame that is not the one just sent: python-can hears itself."""
    while (got := bus.recv(5)) is not None:
        if got.arbitration_id != sent.arbitration_id:
            return got
    return None


def talk(bus):
    for sent in FRAMES:
        # Neither is answered: CAN FD and error frames are none of classic CAN's.
        bus.send(can.Message(arbitration_id=0x601, is_fd=True, data=bytes(12)))
        bus.send(can.Message(arbitration_id=0x602, is_error_frame=True))
        while bus.recv(0.05) is not None:
            pass
        bus.send(sent)
        got = next_foreign(bus, sent)
        assert got is not None, f"no answer to {sent}"
        assert mirrored(sent, got), f"{sent} was answered by {got}"
    bus.send(can.Message(arbitration_id=0x7F0, is_extended_id=False))


def main(mirror):
    for name, (group, port) in GROUPS.items():
        with subprocess.Popen([mirror, name], stdout=subprocess.PIPE) as partner:
            assert partner.stdout.readline() == b"ready\n", f"{name}: the mirror does not start"
            with can.Bus(channel=group, port=port, interface="udp_multicast") as bus:
                talk(bus)
            assert partner.wait(10) == 0, name
        print(f"{name}: {len(FRAMES)} frames both ways")


main(sys.argv[1])

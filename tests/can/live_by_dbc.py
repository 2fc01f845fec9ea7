#!/usr/bin/python3
"""live_by_dbc.py INTERFACE NODE DBC HOST_SIM: canmatrix decodes live frames to the right numbers.

The frames' values are compared with what the node says of the same objects by SDO.
"""

import subprocess
import sys
import time

import can
import canmatrix.formats


def main(interface, node, dbc, host_sim):
    matrix = next(iter(canmatrix.formats.loadp(dbc).values()))
    bus = can.Bus(channel=interface, interface="socketcan")
    bus.send(can.Message(arbitration_id=0, data=[1, node], is_extended_id=False))
    decoded = {}
    until = time.monotonic() + 600  # only what hangs takes so long: tests/patience.hpp
    while time.monotonic() < until and len(decoded) < 5:
        bus.send(can.Message(arbitration_id=0x80, data=[], is_extended_id=False))
        message = bus.recv(1)
        # The file is of node 1.
        if message is None or message.arbitration_id & 0x7F != node:
            continue
        cob = message.arbitration_id & 0x780
        if cob not in (0x180, 0x280):
            continue
        frame = matrix.frame_by_id(canmatrix.ArbitrationId(cob | 1))
        assert frame is not None, f"{cob | 1:03X}h is not in {dbc}"
        for name, value in frame.decode(bytes(message.data)).items():
            decoded[name] = float(value.phys_value)
    assert decoded, "no frame came"
    print(decoded)
    position = float(
        subprocess.check_output(
            [host_sim, "can", "--can", interface, "--node", str(node), "get", "6064"], text=True
        )
    )
    found = [value for name, value in decoded.items() if "actual" in name.lower() and "position" in name.lower()]
    assert found, f"no position among {sorted(decoded)}"
    assert abs(found[0] - position) < 20, f"position {found[0]} um in the frame, {position} um by SDO"


main(sys.argv[1], int(sys.argv[2]), sys.argv[3], sys.argv[4])

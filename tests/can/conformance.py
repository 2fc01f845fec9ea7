#!/usr/bin/python3
"""conformance.py INTERFACE NODE: what the standard asks of a node, by raw frames over python-can.

Each check is a function; its first line says what is asked. Exits with 1 when one fails.
"""

import struct
import sys
import time
import traceback

import can

NAN, INFINITY = float("nan"), float("inf")
# Only what hangs takes so long: tests/patience.hpp.
TIMEOUT_S = 600


class Failure(AssertionError):
    """What the node did otherwise."""


class Abort(Exception):
    """The node's answer to a transfer."""

    def __init__(self, code):
        super().__init__(f"abort {code:08X}h")
        self.code = code


def crc16(data):
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


class Node:
    def __init__(self, interface, node):
        self.node = node
        self.bus = can.Bus(channel=interface, interface="socketcan")

    # Frames.

    def send(self, cob, data=b""):
        self.bus.send(can.Message(arbitration_id=cob, data=bytes(data), is_extended_id=False))

    def flush(self):
        while self.bus.recv(0) is not None:
            pass

    def wait(self, cob, timeout=TIMEOUT_S):
        """The data of the next frame with this identifier, or None."""
        until = time.monotonic() + timeout
        while (left := until - time.monotonic()) > 0:
            message = self.bus.recv(left)
            if message is not None and message.arbitration_id == cob and not message.is_error_frame:
                return bytes(message.data)
        return None

    def until(self, what, condition):
        """Waits for a condition."""
        until = time.monotonic() + TIMEOUT_S
        while not condition():
            expect(time.monotonic() < until, what)

    def handled(self):
        """Waits until the node has handled what was sent so far, and returns the identifiers of what it
        has sent meanwhile. It takes frames in their order; what it sends by itself may come a round later,
        so it is asked twice."""
        seen = []
        for _ in range(2):
            self.send(0x600 + self.node, struct.pack("<BHB4x", 0x40, 0x1000, 0))
            seen += self.frames_until(
                lambda m: m.arbitration_id == 0x580 + self.node
                and bytes(m.data[:4]) == b"\x43\x00\x10\x00"
            )[:-1]
        return seen

    def beats(self, count, cob=0x700):
        """Identifiers of what comes until so many heartbeats, or frames of another kind, have come: the
        node's own measure of time."""
        left = iter(range(count - 1, -1, -1))
        return self.frames_until(lambda m: m.arbitration_id == cob + self.node and next(left) == 0)

    def frames_until(self, is_last):
        seen = []
        until = time.monotonic() + TIMEOUT_S
        while (left := until - time.monotonic()) > 0:
            message = self.bus.recv(left)
            if message is None or message.is_error_frame:
                continue
            seen.append(message.arbitration_id)
            if is_last(message):
                return seen
        raise Failure(f"the last frame does not come; {sorted(set(map(hex, seen)))} did")

    def state_is_said(self, state):
        """Waits for a heartbeat with this state."""
        until = time.monotonic() + TIMEOUT_S
        while self.wait(0x700 + self.node) != bytes([state]):
            expect(time.monotonic() < until, f"state {state:02X}h is said")

    def nmt(self, command, node=None):
        self.send(0, [command, self.node if node is None else node])

    # SDO.

    def ask(self, data, timeout=TIMEOUT_S):
        self.flush()
        self.send(0x600 + self.node, bytes(data).ljust(8, b"\0"))
        answer = self.wait(0x580 + self.node, timeout)
        if answer is None:
            raise Failure("no answer to an SDO request")
        if answer[0] == 0x80:
            raise Abort(struct.unpack("<I", answer[4:])[0])
        return answer

    def upload(self, index, sub=0):
        first = self.ask(struct.pack("<BHB", 0x40, index, sub))
        if first[0] & 2:
            return first[4 : 8 - (first[0] >> 2 & 3 if first[0] & 1 else 0)]
        data, toggle = b"", 0
        while True:
            part = self.ask([0x60 | toggle])
            expect(part[0] & 0x10 == toggle, "the toggle bit alternates")
            data += part[1 : 8 - (part[0] >> 1 & 7)]
            toggle ^= 0x10
            if part[0] & 1:
                return data

    def download(self, index, sub, data):
        self.ask(struct.pack("<BHB", 0x23 | (4 - len(data)) << 2, index, sub) + data)

    def segmented(self, index, sub, data, announced=None):
        size = len(data) if announced is None else announced
        self.ask(struct.pack("<BHBI", 0x21, index, sub, size))
        toggle = 0
        while True:
            part, data = data[:7], data[7:]
            self.ask(bytes([toggle | (7 - len(part)) << 1 | (not data)]) + part)
            toggle ^= 0x10
            if not data:
                return

    def block_upload(self, index, sub=0, size=127):
        first = self.ask(struct.pack("<BHBB", 0xA4, index, sub, size))
        expect(first[0] & 0xE0 == 0xC0, "a block upload is answered by C0h")
        self.send(0x600 + self.node, bytes([0xA3]).ljust(8, b"\0"))
        data, last = b"", False
        while not last:
            number = 0
            while number < size and not last:
                part = self.wait(0x580 + self.node)
                expect(part is not None, "the segments of a block come")
                expect(part[0] & 0x7F == number + 1, "segments are numbered from 1")
                number += 1
                last = bool(part[0] & 0x80)
                data += part[1:]
            self.send(0x600 + self.node, bytes([0xA2, number, size]).ljust(8, b"\0"))
        end = self.wait(0x580 + self.node)
        expect(end[0] & 0xE3 == 0xC1, "a block upload ends with C1h")
        data = data[: len(data) - (end[0] >> 2 & 7)]
        if first[0] & 4:
            expect(struct.unpack("<H", end[1:3])[0] == crc16(data), "the checksum is right")
        if first[0] & 2:
            expect(struct.unpack("<I", first[4:])[0] == len(data), "the size is as announced")
        self.send(0x600 + self.node, bytes([0xA1]).ljust(8, b"\0"))
        return data

    def block_download(self, index, sub, data, crc=None):
        first = self.ask(struct.pack("<BHBI", 0xC6, index, sub, len(data)))
        expect(first[0] & 0xE3 == 0xA0, "a block download is answered by A0h")
        segments = [data[i : i + 7] for i in range(0, len(data), 7)]
        expect(len(segments) <= first[4], "the block is long enough for this test")
        self.flush()
        for number, part in enumerate(segments, 1):
            last = 0x80 if number == len(segments) else 0
            self.send(0x600 + self.node, bytes([last | number]) + part.ljust(7, b"\0"))
        answer = self.wait(0x580 + self.node)
        expect(answer is not None and answer[0] == 0xA2, "a block is acknowledged by A2h")
        expect(answer[1] == len(segments), "all segments are acknowledged")
        checksum = crc16(data) if crc is None else crc
        end = self.ask(bytes([0xC1 | (-len(data) % 7) << 2]) + struct.pack("<H", checksum))
        expect(end[0] == 0xA1, "a block download ends with A1h")

    # Objects by type.

    def u(self, index, sub=0):
        return int.from_bytes(self.upload(index, sub), "little")

    def real(self, index, sub=0):
        return struct.unpack("<f", self.upload(index, sub))[0]

    def set_u(self, index, sub, value, size):
        self.download(index, sub, value.to_bytes(size, "little"))

    def set_real(self, index, sub, value):
        self.download(index, sub, struct.pack("<f", value))

    def boot(self):
        """Resets the node and waits for it."""
        self.flush()
        self.nmt(0x81)
        expect(self.wait(0x700 + self.node) == b"\0", "a boot-up message comes")
        self.until("the loop begins", lambda: self.u(0x2210, 1) > 0)
        self.flush()


def expect(fact, what):
    if not fact:
        raise Failure(f"not so: {what}")


def refuses(code, call, *arguments):
    try:
        call(*arguments)
    except Abort as abort:
        expect(abort.code == code, f"the abort is {code:08X}h; it is {abort.code:08X}h")
        return
    raise Failure(f"accepted; must be refused with {code:08X}h")


CHECKS = []


def check(function):
    CHECKS.append(function)
    return function


# Network management.


@check
def one_boot_up(n):
    """A reset gives one boot-up message, and no other."""
    for command in (0x81, 0x82):
        n.flush()
        n.nmt(command)
        expect(n.wait(0x700 + n.node) == b"\0", "a boot-up message comes")
        expect(0x700 + n.node not in n.handled(), "it comes once")
        n.until("the loop begins", lambda: n.u(0x2210, 1) > 0)


@check
def nmt_states(n):
    """Start, stop, pre-operational; as the heartbeat says it."""
    n.set_u(0x1017, 0, 50, 2)
    for command, state in ((1, 5), (2, 4), (0x80, 0x7F), (1, 5), (0x80, 0x7F)):
        n.nmt(command)
        n.state_is_said(state)
        expect(n.wait(0x700 + n.node) == bytes([state]), f"{command:02X}h leads to {state:02X}h")
    n.set_u(0x1017, 0, 0, 2)


@check
def nmt_broadcast(n):
    """Node-id 0 means everybody; another node-id somebody else."""
    n.set_u(0x1017, 0, 50, 2)
    n.nmt(1, 0)
    n.state_is_said(5)
    n.nmt(0x80, n.node % 127 + 1)
    n.handled()
    n.flush()
    expect(n.wait(0x700 + n.node) == b"\x05", "another's command does nothing")
    n.nmt(0x80, 0)
    n.set_u(0x1017, 0, 0, 2)


@check
def nmt_wrong_length(n):
    """NMT commands of another length, and unknown ones, are ignored."""
    n.set_u(0x1017, 0, 50, 2)
    for data in ([1], [1, n.node, 0], [], [0x55, n.node]):
        n.send(0, data)
    n.handled()
    n.flush()
    expect(n.wait(0x700 + n.node) == b"\x7F", "it stays pre-operational")
    n.set_u(0x1017, 0, 0, 2)


@check
def stopped_is_silent(n):
    """Stopped: heartbeat and NMT only; no SDO, no PDO, no answer to SYNC."""
    n.set_u(0x1017, 0, 50, 2)
    n.nmt(1)
    n.nmt(2)
    n.state_is_said(4)
    n.flush()
    n.send(0x600 + n.node, struct.pack("<BHB4x", 0x40, 0x1000, 0))
    n.send(0x80)
    n.send(0x200 + n.node, [6, 0, 1])
    seen = set(n.beats(10))
    expect(seen == {0x700 + n.node}, f"only heartbeats come; {sorted(map(hex, seen))} did")
    n.nmt(0x80)
    n.set_u(0x1017, 0, 0, 2)


@check
def pre_operational_has_no_pdo(n):
    """Pre-operational: SDO, no PDO."""
    n.set_u(0x1017, 0, 50, 2)
    n.flush()
    n.send(0x80)
    seen = n.beats(8)
    n.set_u(0x1017, 0, 0, 2)
    expect(not set(seen) & {0x180 + n.node, 0x280 + n.node, 0x380 + n.node, 0x480 + n.node},
           "no PDO comes")
    expect(n.u(0x1000) & 0xFFFF == 402, "the device type is that of a drive")


@check
def heartbeat_period(n):
    """1017h: heartbeats come as often as it says, by the node's own clock: as often as TPDO 1."""
    expect(n.u(0x1800, 5) == 100, "TPDO 1 comes each 100 ms by default")
    n.nmt(1)
    for period_ms, least, most in ((100, 13, 17), (50, 27, 33)):
        n.set_u(0x1017, 0, period_ms, 2)
        n.flush()
        count = n.beats(15, 0x180).count(0x700 + n.node)
        expect(least <= count <= most, f"{count} of {period_ms} ms in 15 of 100 ms")
    n.set_u(0x1017, 0, 0, 2)
    n.handled()
    n.flush()
    expect(0x700 + n.node not in n.beats(5, 0x180), "0 ends them")
    n.nmt(0x80)


@check
def heartbeat_consumer(n):
    """1016h: watched from the first heartbeat on; its loss gives EMCY 8130h."""
    watched = 0x7D
    n.set_u(0x1017, 0, 100, 2)
    n.set_u(0x1016, 1, watched << 16 | 200, 4)
    n.flush()
    expect(0x80 + n.node not in n.beats(6), "nothing before the first heartbeat")
    n.send(0x700 + watched, [5])
    emergency = n.wait(0x80 + n.node)
    expect(emergency is not None and emergency[:2] == b"\x30\x81", "EMCY 8130h after it")
    expect(emergency[2] & 0x10, "the communication bit of 1001h is set")
    expect(n.u(0x1003) >= 1 and n.u(0x1003, 1) & 0xFFFF == 0x8130, "1003h remembers it")
    n.set_u(0x1016, 1, 0, 4)
    n.boot()


# SDO.


@check
def missing_objects(n):
    """A missing object is 06020000h, a missing sub-index 06090011h."""
    refuses(0x06020000, n.upload, 0x1FFF, 0)
    refuses(0x06020000, n.upload, 0x5FFF, 1)
    refuses(0x06090011, n.upload, 0x1018, 9)
    refuses(0x06090011, n.upload, 0x2100, 99)
    refuses(0x06090011, n.upload, 0x1000, 1)
    refuses(0x06020000, n.set_u, 0x1FFF, 0, 1, 4)
    refuses(0x06090011, n.set_u, 0x2100, 99, 1, 4)


@check
def read_only(n):
    """Writing what is read-only is 06010002h, reading what is write-only 06010001h."""
    refuses(0x06010002, n.set_u, 0x1000, 0, 1, 4)
    refuses(0x06010002, n.set_u, 0x1018, 1, 1, 4)
    refuses(0x06010002, n.set_u, 0x6041, 0, 1, 2)
    refuses(0x06010001, n.upload, 0x2003, 2)


@check
def lengths(n):
    """Too long is 06070012h, too short 06070013h; the old value stays."""
    before = n.u(0x1017)
    refuses(0x06070012, n.set_u, 0x1017, 0, 7, 4)
    refuses(0x06070013, n.set_u, 0x1017, 0, 7, 1)
    refuses(0x06070013, n.set_u, 0x2100, 1, 7, 2)
    refuses(0x06070012, n.segmented, 0x2100, 1, bytes(9))
    refuses(0x06070013, n.segmented, 0x2100, 1, bytes(3))
    expect(n.u(0x1017) == before, "the value is the old one")


@check
def unknown_command(n):
    """An unknown command is 05040001h."""
    refuses(0x05040001, n.ask, struct.pack("<BHB", 0xE0, 0x1000, 0))
    refuses(0x05040001, n.ask, [0x60])
    refuses(0x05040001, n.ask, [0x00])


@check
def client_abort(n):
    """An abort of the client ends its transfer and is not answered."""
    n.ask(struct.pack("<BHB", 0x40, 0x1008, 0))
    n.flush()
    n.send(0x600 + n.node, struct.pack("<BHBI", 0x80, 0x1008, 0, 0x08000000))
    expect(0x580 + n.node not in n.handled(), "no answer to an abort")
    expect(n.u(0x1000) != 0, "the next transfer works")


@check
def wrong_length_of_a_request(n):
    """Requests of less than 8 bytes are ignored."""
    n.flush()
    n.send(0x600 + n.node, struct.pack("<BHB", 0x40, 0x1000, 0))
    expect(0x580 + n.node not in n.handled(), "no answer")


@check
def toggle(n):
    """A toggle bit that stands still is 05030000h."""
    n.ask(struct.pack("<BHB", 0x40, 0x1008, 0))
    refuses(0x05030000, n.ask, [0x70])
    n.ask(struct.pack("<BHBI", 0x21, 0x2100, 1, 4))
    refuses(0x05030000, n.ask, [0x10])


@check
def segment_time_out(n):
    """A transfer that is left alone for longer than 2004h:2 is aborted with 05040000h."""
    before = n.upload(0x2004, 2)
    n.set_real(0x2004, 2, 1.0)
    n.ask(struct.pack("<BHB", 0x40, 0x1008, 0))
    answer = n.wait(0x580 + n.node)
    n.download(0x2004, 2, before)
    expect(answer is not None and answer[0] == 0x80, "an abort comes by itself")
    expect(struct.unpack("<I", answer[4:])[0] == 0x05040000, "it is 05040000h")


@check
def texts(n):
    """1008h, 1009h, 100Ah are texts, expedited or segmented, and the same by blocks."""
    for index in (0x1008, 0x1009, 0x100A):
        text = n.upload(index)
        expect(text.decode("ascii").isprintable() and text, f"{index:04X}h is a text")
        expect(n.block_upload(index) == text, "the same by blocks")


@check
def four_bytes_each_way(n):
    """An object of 4 bytes by expedited, segmented and block transfers."""
    before = n.upload(0x2100, 1)
    for value, write in ((3.0, n.download), (4.0, n.segmented), (5.0, n.block_download)):
        write(0x2100, 1, struct.pack("<f", value))
        expect(n.real(0x2100, 1) == value, f"{write.__name__} has written it")
        expect(n.block_upload(0x2100, 1) == struct.pack("<f", value), "and blocks read it")
    n.download(0x2100, 1, before)


@check
def block_sizes(n):
    """Block sizes 0 and 128 are 05040002h; 1 and 127 work."""
    for size in (0, 128, 255):
        refuses(0x05040002, n.ask, struct.pack("<BHBB", 0xA4, 0x1008, 0, size))
    expect(n.block_upload(0x1008, 0, 1) == n.upload(0x1008), "blocks of one segment work")


@check
def block_checksum(n):
    """A block download with a wrong checksum is 05040004h; the old value stays."""
    before = n.upload(0x2100, 1)
    wrong = crc16(struct.pack("<f", 6.0)) ^ 1
    refuses(0x05040004, n.block_download, 0x2100, 1, struct.pack("<f", 6.0), wrong)
    expect(n.upload(0x2100, 1) == before, "the value is the old one")


@check
def block_repeats_what_was_lost(n):
    """Segments that were not acknowledged come again."""
    text = n.upload(0x1021)
    if len(text) < 60:
        return
    first = n.ask(struct.pack("<BHBB", 0xA4, 0x1021, 0, 5))
    n.send(0x600 + n.node, bytes([0xA3]).ljust(8, b"\0"))
    block = [n.wait(0x580 + n.node) for _ in range(5)]
    # As if the third had been lost.
    n.send(0x600 + n.node, bytes([0xA2, 2, 5]).ljust(8, b"\0"))
    again = n.wait(0x580 + n.node)
    expect(again[0] == 1 and again[1:] == block[2][1:], "the third comes as the first")
    n.send(0x600 + n.node, struct.pack("<BHBI", 0x80, 0x1021, 0, 0x08000000))
    n.handled()
    n.flush()
    expect(first[0] & 4, "it knows checksums")


@check
def values_out_of_range(n):
    """Not a number is 06090030h, too high 06090031h, too low 06090032h; the old value stays."""
    before = n.upload(0x2020, 2)
    for value in (NAN, INFINITY, -INFINITY):
        refuses(0x06090030, n.set_real, 0x2020, 2, value)
    refuses(0x06090031, n.set_real, 0x2020, 2, 1e6)
    refuses(0x06090032, n.set_real, 0x2020, 2, 0.0)
    refuses(0x06090032, n.set_real, 0x2020, 2, -1.0)
    expect(n.upload(0x2020, 2) == before, "the value is the old one")


# Process data.


@check
def mapping_while_valid(n):
    """A mapping changes only while its PDO is not valid and its count is 0."""
    try:
        n.set_u(0x1A00, 1, 0x60410010, 4)
        raise Failure("a mapping entry was written while it counted")
    except Abort:
        pass
    cob = n.u(0x1800, 1)
    n.set_u(0x1800, 1, cob | 1 << 31, 4)
    count = n.u(0x1A00)
    entries = [n.u(0x1A00, i + 1) for i in range(count)]
    n.set_u(0x1A00, 0, 0, 1)
    n.set_u(0x1A00, 1, 0x60640020, 4)
    refuses(0x06020000, n.set_u, 0x1A00, 2, 0x5FFF0008, 4)
    refuses(0x06040041, n.set_u, 0x1A00, 2, 0x10180120, 4)
    n.set_u(0x1A00, 2, 0x606C0020, 4)
    n.set_u(0x1A00, 3, 0x60410010, 4)
    refuses(0x06040042, n.set_u, 0x1A00, 0, 3, 1)
    for i, entry in enumerate(entries):
        n.set_u(0x1A00, i + 1, entry, 4)
    n.set_u(0x1A00, 0, count, 1)
    n.set_u(0x1800, 1, cob, 4)


@check
def cob_while_valid(n):
    """A COB-ID changes only while the PDO is not valid; restricted identifiers never."""
    cob = n.u(0x1800, 1)
    try:
        n.set_u(0x1800, 1, (cob & ~0x7FF) | 0x1C0, 4)
        raise Failure("the identifier was changed while it was valid")
    except Abort:
        pass
    n.set_u(0x1800, 1, cob | 1 << 31, 4)
    for restricted in (0x000, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF):
        refuses(0x06090030, n.set_u, 0x1800, 1, 1 << 30 | restricted, 4)
    n.set_u(0x1800, 1, cob, 4)
    expect(n.u(0x1800, 1) == cob, "it is as before")


@check
def sync_pdo(n):
    """A synchronous TPDO answers each n-th SYNC in operational, and only there."""
    expect(n.u(0x1801, 2) == 1, "TPDO 2 is synchronous by default")
    n.nmt(1)
    for every, expected in ((1, 6), (3, 2)):
        n.set_u(0x1801, 2, every, 1)
        n.flush()
        count = 0
        for _ in range(6):
            n.send(0x80)
            count += n.handled().count(0x280 + n.node)
        expect(count == expected, f"type {every} answers {expected} of 6; {count} came")
    n.set_u(0x1801, 2, 1, 1)
    n.nmt(0x80)


@check
def sync_counter(n):
    """With 1019h only SYNC with a counter counts; otherwise EMCY 8240h."""
    n.set_u(0x1019, 0, 10, 1)
    n.nmt(1)
    n.handled()
    n.flush()
    n.send(0x80, [1])
    expect(0x280 + n.node in n.handled(), "a SYNC with a counter is one")
    n.send(0x80)
    expect(n.wait(0x80 + n.node) is not None, "one without is reported")
    n.nmt(0x80)
    n.set_u(0x1019, 0, 0, 1)
    n.boot()


@check
def short_rpdo(n):
    """An RPDO that is too short is not taken and gives EMCY 8210h."""
    n.nmt(1)
    before = n.u(0x607A)
    n.flush()
    n.send(0x300 + n.node, [1, 2])
    emergency = n.wait(0x80 + n.node)
    expect(emergency is not None and emergency[:2] == b"\x10\x82", "EMCY 8210h")
    expect(n.u(0x607A) == before, "the target is the old one")
    n.send(0x300 + n.node, struct.pack("<ii", 123, 0))
    n.until("a whole one is taken", lambda: n.u(0x607A) == 123)
    n.nmt(0x80)
    n.boot()


@check
def event_timer(n):
    """TPDO 1 comes by its event timer in operational."""
    n.set_u(0x1800, 5, 50, 2)
    n.set_u(0x1017, 0, 100, 2)
    n.nmt(1)
    n.handled()
    n.flush()
    count = n.beats(10).count(0x180 + n.node)
    expect(18 <= count <= 22, f"20 of 50 ms in 10 heartbeats of 100 ms; {count} came")
    n.nmt(0x80)
    n.set_u(0x1017, 0, 0, 2)
    n.set_u(0x1800, 5, 100, 2)


# Errors, store and restore.


@check
def error_history(n):
    """1003h:0 takes 0 only."""
    refuses(0x06090030, n.set_u, 0x1003, 0, 1, 1)
    n.set_u(0x1003, 0, 0, 1)
    expect(n.u(0x1003) == 0, "it is empty then")
    refuses(0x08000024, n.upload, 0x1003, 1)


@check
def store_signature(n):
    """1010h and 1011h take their signatures only."""
    for index in (0x1010, 0x1011):
        for wrong in (b"SAVE", b"evas", bytes(4)):
            try:
                n.download(index, 1, wrong)
                raise Failure(f"{index:04X}h took {wrong}")
            except Abort as abort:
                expect(abort.code in (0x08000020, 0x08000021, 0x06090030), "the abort says why")


@check
def save_and_restore(n):
    """What is saved outlives a reset; what is restored is the default after the next."""
    default = n.u(0x1017)
    n.set_u(0x1017, 0, 700, 2)
    n.download(0x1010, 1, b"save")
    n.boot()
    expect(n.u(0x1017) == 700, "the saved value is there")
    n.download(0x1011, 1, b"load")
    expect(n.u(0x1017) == 700, "restoring waits for the reset")
    n.boot()
    expect(n.u(0x1017) == default, "the default is there again")


@check
def unsaved_is_gone(n):
    """What is not saved is gone after a reset."""
    default = n.u(0x1017)
    n.set_u(0x1017, 0, 333, 2)
    n.boot()
    expect(n.u(0x1017) == default, "the default is there again")


@check
def identity(n):
    """1018h has four entries; 1000h is that of CiA 402."""
    expect(n.u(0x1018) == 4, "1018h:0 is 4")
    expect(n.u(0x1018, 4) == 1000 + n.node, "the serial number is the device's")
    expect(n.u(0x1000) & 0xFFFF == 402, "1000h says 402")


@check
def verify_configuration(n):
    """1020h keeps what is written until something changes that can be stored."""
    n.set_u(0x1020, 1, 11, 4)
    n.set_u(0x1020, 2, 22, 4)
    expect((n.u(0x1020, 1), n.u(0x1020, 2)) == (11, 22), "it keeps what is written")
    n.set_u(0x1015, 0, 5, 2)
    expect((n.u(0x1020, 1), n.u(0x1020, 2)) == (0, 0), "a change clears it")
    n.set_u(0x1015, 0, 100, 2)


# LSS, and what the loop tells.


@check
def lss_bit_timing(n):
    """LSS: a bit rate that is not supported is refused, and nothing changes."""
    n.send(0x7E5, [0x04, 1, 0, 0, 0, 0, 0, 0])
    n.flush()
    n.send(0x7E5, [0x13, 0, 2, 0, 0, 0, 0, 0])
    expect(n.wait(0x7E4) == bytes([0x13, 1, 0, 0, 0, 0, 0, 0]), "error 1: not supported")
    n.send(0x7E5, [0x5E, 0, 0, 0, 0, 0, 0, 0])
    expect(n.wait(0x7E4) == bytes([0x5E, n.node, 0, 0, 0, 0, 0, 0]), "the node-id is asked for")
    n.send(0x7E5, [0x11, 128, 0, 0, 0, 0, 0, 0])
    expect(n.wait(0x7E4) == bytes([0x11, 1, 0, 0, 0, 0, 0, 0]), "node-id 128 is out of range")
    n.send(0x7E5, [0x04, 0, 0, 0, 0, 0, 0, 0])
    expect(n.u(0x1000) & 0xFFFF == 402, "it goes on")


@check
def lss_selective(n):
    """LSS: only the node with this identity is switched to configuration."""
    identity = [n.u(0x1018, sub) for sub in (1, 2, 3, 4)]
    for wrong in (1, 0):
        n.flush()
        for part, value in enumerate(identity):
            value += wrong if part == 3 else 0
            n.send(0x7E5, struct.pack("<BI3x", 0x40 + part, value))
        if wrong:
            expect(0x7E4 not in n.handled(), "another serial number is not it")
    answer = n.wait(0x7E4)
    expect(answer[0] == 0x44, "44h says that it is selected")
    n.send(0x7E5, [0x04, 0, 0, 0, 0, 0, 0, 0])


@check
def loop_timing(n):
    """2210h tells of the loop: its steps go on."""
    before = n.u(0x2210, 1)
    n.until("steps are counted", lambda: n.u(0x2210, 1) > before)
    expect(n.real(0x2210, 5) > 0, "and how long they take")


# The drive.


@check
def no_jump_over_states(n):
    """The drive enters Operation enabled only through all states before."""
    n.set_u(0x6040, 0, 0, 2)
    n.until("disabled", lambda: n.u(0x6041) & 0x4F == 0x40)
    n.set_u(0x6040, 0, 0x0F, 2)
    steps = n.u(0x2210, 1)
    n.until("the loop goes on", lambda: n.u(0x2210, 1) > steps + 50)
    expect(n.u(0x6041) & 0x6F != 0x27, "0Fh alone does not enable")
    n.set_u(0x6040, 0, 0, 2)
    for word, state in ((0x06, 0x21), (0x07, 0x23), (0x06, 0x21), (0x00, 0x40)):
        n.set_u(0x6040, 0, word, 2)
        mask = 0x4F if state == 0x40 else 0x6F
        n.until(f"{word:02X}h leads to {state:02X}h", lambda: n.u(0x6041) & mask == state)


@check
def modes(n):
    """6060h takes supported modes only, and 6061h shows them."""
    for mode in (1, 6, 8, -1, -2, -3, 0):
        n.download(0x6060, 0, struct.pack("<b", mode))
        n.until(f"6061h shows {mode}", lambda: struct.unpack("<b", n.upload(0x6061))[0] == mode)
    for mode in (2, 3, 7, 9, -10, 127):
        refuses(0x06090030, n.download, 0x6060, 0, struct.pack("<b", mode))


def main(interface, node):
    n = Node(interface, node)
    n.boot()
    failed = 0
    for function in CHECKS:
        try:
            function(n)
        except (Failure, Abort) as error:
            failed += 1
            line = traceback.extract_tb(error.__traceback__)[1].lineno
            print(f"failed: {function.__name__}, line {line}: {error}\n  asked: {function.__doc__}")
            n.boot()
    print(f"conformance: {len(CHECKS) - failed} of {len(CHECKS)} checks passed")
    n.bus.shutdown()
    return 1 if failed else 0


sys.exit(main(sys.argv[1], int(sys.argv[2])))

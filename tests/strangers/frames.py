# SPDX-License-Identifier: GPL-2.0-or-later
"""frames.py INTERFACE - frames by hand against `tgm bus --timing real drive-cia402 dio-8x8`.

What an interface must do that no well-behaved master tries. Prints "N passed, M failed".
"""
import socket
import struct
import sys
import time

passed = failed = 0
SOURCE = bytes.fromhex("100000000001")


def check(good, what):
    global passed, failed
    if good:
        passed += 1
    else:
        failed += 1
        print("not ok ", what)


def ethernet(payload, ethertype=0x88A4):
    return b"\xff" * 6 + SOURCE + struct.pack(">H", ethertype) + payload


def datagram(command, index, address, data, more=False):
    return struct.pack("<BBIHH", command, index, address, len(data) | more << 15, 0) + data + b"\0\0"


def ecat(*datagrams):
    body = b"".join(datagrams)
    return ethernet(struct.pack("<H", len(body) | 1 << 12) + body)


def brd(index, length=2):
    return ecat(datagram(7, index, 0, bytes(length)))


class Cable:
    def __init__(self, interface):
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0)
        self.socket.setsockopt(263, 23, 1)  # SOL_PACKET, PACKET_IGNORE_OUTGOING
        self.socket.bind((interface, 0x0003))

    def answer(self, frame, patience=2.0):
        """The next frame that comes after this one was sent; None when none comes."""
        self.socket.send(frame)
        return self.next(patience)

    def next(self, patience):
        self.socket.settimeout(patience)
        try:
            while True:
                frame = self.socket.recv(2048)
                if frame[12:14] in (b"\x88\xa4", b"\x08\x06") and frame[0:6] == b"\xff" * 6:
                    return frame
        except TimeoutError:
            return None


def main():
    cable = Cable(sys.argv[1])
    short = brd(1)
    check(len(short) < 60, "this one is short")
    back = cable.answer(short)
    check(back is not None and len(back) == 60, "a short frame comes back with 60 bytes")
    check(back[:6] == b"\xff" * 6 and back[6:12] == bytes.fromhex("120000000001"), "the local bit is set on the way")
    check(struct.unpack_from("<H", back, 18) == (2,), "both slaves counted the address up")
    check(struct.unpack_from("<H", back, 28) == (2,), "both slaves counted")
    check(back[30:] == bytes(30), "what is padded stays zero")

    longest = brd(2, 1486)
    check(len(longest) == 1514, "this one is the longest there is")
    check(len(cable.answer(longest) or b"") == 1514, "it comes back whole")
    soonest = 1.0
    for i in range(50):
        began = time.monotonic()
        cable.answer(longest)
        soonest = min(soonest, time.monotonic() - began)
    check(soonest > (1514 + 24) * 80e-9, f"no sooner than the wire allows: {soonest * 1e6:.0f} us")

    check(cable.answer(ethernet(bytes(46), 0x0806), 0.3) is None, "another protocol is not answered")
    check(cable.answer(ethernet(struct.pack("<H", 60 | 1 << 12) + bytes(44)), 0.3) is None,
          "a frame that claims more than it has is not answered")
    check(cable.answer(ecat(datagram(7, 3, 0, bytes(2), more=True)), 0.3) is None,
          "a frame whose last datagram promises another is not answered")
    check(cable.next(0.3) is None, "nothing comes by itself")

    # More than the bus takes at once: all come back, in their order.
    count, indexes = 100, []
    for i in range(count):
        cable.socket.send(brd(i))
    while len(indexes) < count:
        back = cable.next(2.0)
        if back is None:
            break
        indexes.append(back[17])
    check(indexes == list(range(count)), f"{len(indexes)} of {count} frames come back in order")
    check(cable.next(0.3) is None, "and each once")
    print(f"{passed} passed, {failed} failed")
    return failed != 0


sys.exit(main())

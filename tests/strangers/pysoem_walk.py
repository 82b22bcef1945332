# SPDX-License-Identifier: GPL-2.0-or-later
"""pysoem_walk.py INTERFACE - pysoem on the bus drive, terminal, drive, terminal.

Scan, names, object dictionaries, SDO, mapping, distributed clocks, OP, drives that move, a slave that is
brought back after its master lost it. Prints what failed and, last, "N passed, M failed".
"""
import struct
import sys
import time

import pysoem

DRIVE, TERMINAL = "Simulated servo drive CiA 402", "Simulated DIO 8 in 8 out"
NAMES = [DRIVE, TERMINAL, DRIVE, TERMINAL]
VENDOR, PRODUCT = 0x5447534D, {DRIVE: 0x04020001, TERMINAL: 0x00D10808}
EXPECTED_WKC = 4 * 3
CYCLE = 0.001

passed = failed = 0


def check(good, what):
    global passed, failed
    if good:
        passed += 1
    else:
        failed += 1
        print("not ok ", what)


def aborts(code, call, *arguments):
    try:
        call(*arguments)
    except pysoem.SdoError as error:
        return error.abort_code & 0xFFFFFFFF == code
    return False


def walk_dictionary(position, slave):
    objects = slave.od
    check(len(objects) >= 40, f"slave {position}: number of objects")
    indexes = [o.index for o in objects]
    check(indexes == sorted(set(indexes)), f"slave {position}: objects in order")
    by_index = {o.index: o for o in objects}
    check(by_index[0x1008].name == b"device name", f"slave {position}: name of 0x1008")
    check(by_index[0x6064].data_type == pysoem.ECT_INTEGER32, f"slave {position}: type of 0x6064")
    check(by_index[0x6064].bit_length == 32, f"slave {position}: length of 0x6064")
    entries = by_index[0x1018].entries
    check([e.name for e in entries] == [b"number of entries", b"vendor id", b"product code", b"revision", b"serial number"],
          f"slave {position}: entries of 0x1018")
    values = 0
    for o in objects:
        for subindex, entry in enumerate(o.entries or [o]):
            if entry.data_type == 0 or not entry.obj_access & 0x3F:
                continue
            data = slave.sdo_read(o.index, subindex)
            check(entry.data_type == pysoem.ECT_VISIBLE_STRING or len(data) * 8 == entry.bit_length,
                  f"slave {position}: length of 0x{o.index:04x}:{subindex}")
            values += 1
    check(values > 100, f"slave {position}: {values} values")


def walk_sdo(position, slave):
    who = f"slave {position}: "
    check(slave.sdo_read(0x1008, 0) == DRIVE.encode(), who + "0x1008")
    text = slave.sdo_read(0x1009, 0)
    check(len(text) > 128 and text.startswith(b"simulation: ") and text.endswith(b"no heat"),
          who + "a text in segments")
    check(struct.unpack("<I", slave.sdo_read(0x1018, 1)) == (VENDOR,), who + "vendor")
    check(struct.unpack("<I", slave.sdo_read(0x1018, 4)) == (position,), who + "serial number")
    identity = slave.sdo_read(0x1018, 0, ca=True)
    check(struct.unpack("<BxIII", identity[:14]) == (4, VENDOR, PRODUCT[DRIVE], 0x00010000),
          who + "identity by complete access")
    for value in (1, 777777, 5 << 20):
        slave.sdo_write(0x6081, 0, struct.pack("<I", value))
        check(slave.sdo_read(0x6081, 0) == struct.pack("<I", value), who + f"0x6081 = {value}")
    mapping = slave.sdo_read(0x1600, 0, ca=True)
    slave.sdo_write(0x1C12, 0, b"\0")
    slave.sdo_write(0x1600, 0, mapping, ca=True)
    slave.sdo_write(0x1C12, 0, b"\1\0" + struct.pack("<H", 0x1600), ca=True)
    check(slave.sdo_read(0x1600, 0, ca=True) == mapping, who + "mapping written by complete access")
    check(aborts(0x06020000, slave.sdo_read, 0x5FFF, 0), who + "missing object")
    check(aborts(0x06090011, slave.sdo_read, 0x1018, 9), who + "missing subindex")
    check(aborts(0x06010002, slave.sdo_write, 0x6041, 0, b"\0\0"), who + "read-only object")
    check(aborts(0x06070012, slave.sdo_write, 0x6081, 0, b"\0" * 5), who + "too much data")


class Cycle:
    """Process data, once a millisecond, counters watched."""

    def __init__(self, master):
        self.master = master
        self.late = self.short = self.done = 0

    def __call__(self, times=1):
        for _ in range(times):
            self.master.send_processdata()
            wkc = self.master.receive_processdata(50000)
            if wkc < 0:
                self.late += 1
            elif wkc != EXPECTED_WKC:
                self.short += 1
            self.done += 1
            time.sleep(CYCLE)


def command(slave, controlword, target):
    slave.output = struct.pack("<HBxi", controlword, 8, target)


def status(slave):
    return struct.unpack_from("<H", slave.input)[0]


def position_of(slave):
    return struct.unpack_from("<i", slave.input, 4)[0]


def reach_op(master, cycle, slaves):
    for slave in slaves:
        slave.state = pysoem.OP_STATE
        slave.write_state()
    for _ in range(200):
        cycle(10)
        master.read_state()
        if all(slave.state == pysoem.OP_STATE for slave in slaves):
            return True
    return False


def enable(cycle, slave, who):
    for controlword, state in ((6, 0x21), (7, 0x23), (15, 0x27)):
        for _ in range(500):
            command(slave, controlword, position_of(slave))
            cycle()
            if status(slave) & 0x6F == state:
                break
        check(status(slave) & 0x6F == state, who + f"status 0x{state:02x}")


def move(cycle, slave, who):
    begin = target = position_of(slave)
    for _ in range(400):
        target -= 400
        command(slave, 15, target)
        cycle()
    cycle(200)
    check(abs(position_of(slave) - (begin - 160000)) < 300, who + "the axis is where it was sent")
    check(status(slave) & 0x6F == 0x27, who + "still enabled")


def exchange_bits(cycle, slave, who):
    seen = set()
    for i in range(500):
        slave.output = bytes([i & 0xFF])
        cycle()
        seen.add(slave.input[0])
    check(seen == {0, 1}, who + f"input 0 alone goes on and off, not {seen}")


def bring_back(master, cycle, slave, who):
    slave.state = pysoem.INIT_STATE
    slave.write_state()
    check(slave.state_check(pysoem.INIT_STATE, 1000000) == pysoem.INIT_STATE, who + "INIT")
    check(slave.reconfig() == pysoem.SAFEOP_STATE, who + "configured again up to SAFEOP")
    check(reach_op(master, cycle, master.slaves), who + "all in OP again")
    # As after a power cut that took the address along.
    check(slave.recover() > 0, who + "found where it was")


def main():
    pysoem.settings.timeouts.ret = 50000
    pysoem.settings.timeouts.safe = 100000
    master = pysoem.Master()
    master.open(sys.argv[1])
    check(master.config_init() == 4, "number of slaves")
    check([s.name for s in master.slaves] == NAMES, "names")
    check([s.man for s in master.slaves] == [VENDOR] * 4, "vendors")
    check([s.id for s in master.slaves] == [PRODUCT[n] for n in NAMES], "products")
    check([s.rev for s in master.slaves] == [0x00010000] * 4, "revisions")
    for slave in master.slaves:
        check(struct.unpack("<I", slave.eeprom_read(8))[0] == VENDOR, "vendor in the EEPROM")
    drives, terminals = master.slaves[0::2], master.slaves[1::2]
    for number, slave in zip((1, 3), drives):
        walk_sdo(number, slave)
    walk_dictionary(1, drives[0])
    check(master.config_map() == 2 * (8 + 20 + 1 + 1), "size of the process image")
    check(master.config_dc(), "distributed clocks")
    for slave, outputs, inputs in zip(master.slaves, (8, 1, 8, 1), (20, 1, 20, 1)):
        check(len(slave.output) == outputs and len(slave.input) == inputs, "lengths of process data")
    check(master.state_check(pysoem.SAFEOP_STATE, 2000000) == pysoem.SAFEOP_STATE, "SAFEOP")
    check(master.expected_wkc == EXPECTED_WKC, "expected working counter")
    cycle = Cycle(master)
    check(reach_op(master, cycle, master.slaves), "OP")
    cycle.short = 0
    for number, slave in zip((1, 3), drives):
        enable(cycle, slave, f"slave {number}: ")
        move(cycle, slave, f"slave {number}: ")
    for number, slave in zip((2, 4), terminals):
        exchange_bits(cycle, slave, f"slave {number}: ")
    before = master.dc_time
    cycle(100)
    check(master.dc_time - before > 100 * CYCLE * 1e9, "the reference clock goes")
    check(cycle.short == 0, f"{cycle.short} of {cycle.done} working counters are short")
    check(cycle.late < 20, f"{cycle.late} of {cycle.done} frames are late")
    bring_back(master, cycle, drives[0], "slave 1: ")
    cycle.short = 0
    cycle(100)
    check(cycle.short == 0, "working counters after that")
    master.state = pysoem.INIT_STATE
    master.write_state()
    master.close()
    print(f"{passed} passed, {failed} failed")
    return failed != 0


sys.exit(main())

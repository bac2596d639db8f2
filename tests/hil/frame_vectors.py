#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the vectors of frame_test.cpp by struct and zlib, from the tables of docs/protocol.md alone. With --write, puts them there.

    python3 tests/hil/frame_vectors.py [--write]
"""
import re
import struct
import sys
import zlib
from pathlib import Path

VERSION, SESSION, SEQUENCE, TIME_us = 4, 0x0102, 5, 0x01000000
BOARDS = ((1, 1, 1), (2, 2, 1), (4, 4, 2), (8, 8, 8), (4, 0, 2))


def framed(kind, payload):
    plain = struct.pack("<BBHII", VERSION, kind, SESSION, SEQUENCE, TIME_us) + payload
    plain += struct.pack("<I", zlib.crc32(plain))
    return b"".join(bytes([len(block) + 1]) + block for block in plain.split(b"\0")) + b"\0"


def each(what, count, value):
    return b"".join(struct.pack("<" + what, value(k)) for k in range(count))


def vectors(coils, thermocouples, angles):
    def duty(k):
        return 100 * (k + 1)

    telemetry = (struct.pack("<IBB", 70000, 1, 0) + each("B", thermocouples, lambda k: k)
                 + each("B", angles, lambda k: 24 + k) + each("H", coils, duty)
                 + each("I", thermocouples, lambda k: 0x06400190 + (k << 18)) + each("i", thermocouples, lambda k: 2500 - 1000 * k)
                 + each("H", coils, lambda k: 4200 + k) + struct.pack("<H", 42) + each("H", angles, lambda k: 8176 + k)
                 + each("h", angles, lambda k: -4475 + 1500 * k) + struct.pack("<13H", *range(13)))
    return (framed(0x04, each("H", coils, duty) + struct.pack("<H", 220)), framed(0x83, telemetry),
            framed(0x81, struct.pack("<II", 0x12345678, 0x9ABCDEF0) + bytes([3, 2, 1, coils, thermocouples, angles, 2])))


def main():
    text = ""
    for board in BOARDS:
        text += "      {{%d, %d, %d}" % board
        for one in vectors(*board):
            text += ",\n" + "\n".join('       "%s"' % one.hex()[at : at + 112] for at in range(0, 2 * len(one), 112))
        text += "},\n"
    if sys.argv[1:] == ["--write"]:
        file = Path(__file__).with_name("frame_test.cpp")
        before = file.read_text()
        after = re.sub(r"(\} const vectors\[\] = \{\n).*?(\n  \};)", lambda m: m[1] + text.rstrip("\n") + m[2], before, count=1, flags=re.S)
        file.write_text(after)
    print(text, end="")
    disarm = framed(0x03, b"")
    print("disarm:", disarm.hex(" "))


main()

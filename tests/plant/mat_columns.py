#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Vectors of a MATLAB file (version 5, doubles) as columns of CSV, each under its variable's name. Standard library alone.
Usage: mat_columns.py FILE.mat NAME NAME ..."""
import struct
import sys
import zlib


def elements(data):
    """(type, bytes) of each data element; small ones have type and size in one word."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        if kind >> 16:
            yield kind & 0xFFFF, data[at + 4 : at + 4 + (kind >> 16)]
            at += 8
        else:
            yield kind, data[at + 8 : at + 8 + size]
            at += 8 + size + (0 if kind == 15 else -size % 8)


COMPRESSED, MATRIX = 15, 14
FORMATS = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 9: "d"}
found = {}
for kind, body in elements(open(sys.argv[1], "rb").read()[128:]):
    for inner, matrix in elements(zlib.decompress(body)) if kind == COMPRESSED else [(kind, body)]:
        parts = list(elements(matrix)) if inner == MATRIX else []
        if len(parts) >= 4 and parts[3][0] in FORMATS:  # flags, dimensions, name, real part
            found[parts[2][1].decode()] = [v for (v,) in struct.iter_unpack("<" + FORMATS[parts[3][0]], parts[3][1])]
names = sys.argv[2:]
print(",".join(names))
for row in zip(*(found[name] for name in names)):
    print(",".join(repr(float(value)) for value in row))

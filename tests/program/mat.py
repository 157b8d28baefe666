"""A MAT file of level 5, read from the text of its format, has the matrices of a CSV file.
SPDX-License-Identifier: BSD-3-Clause
Usage: mat.py FILE.mat FILE.csv     matrices behind "# NAME ROWS COLUMNS" """
import struct
import sys


def element(data, at):
    """Type and content of the element at a place, and where the next begins."""
    kind, size = struct.unpack_from("=II", data, at)
    if kind >> 16:  # a small one: size and type in four bytes
        return kind & 0xFFFF, data[at + 4:at + 4 + (kind >> 16)], at + 8
    body = data[at + 8:at + 8 + size]
    assert len(body) == size, f"an element of {size} bytes ends after {len(body)}"
    return kind, body, at + 8 + (size if kind == 15 else (size + 7) // 8 * 8)


def mat_matrices(path):
    with open(path, "rb") as file:
        data = file.read()
    assert data[:19] == b"MATLAB 5.0 MAT-file", data[:19]
    version, mark = struct.unpack_from("=HH", data, 124)
    assert version == 0x0100 and mark == 0x4D49, (version, mark)
    at, found = 128, {}
    while at < len(data):
        kind, body, at = element(data, at)
        assert kind == 14, f"an element of type {kind} at the top"
        flags_kind, flags, next_one = element(body, 0)
        sizes_kind, sizes, next_one = element(body, next_one)
        name_kind, name, next_one = element(body, next_one)
        numbers_kind, numbers, next_one = element(body, next_one)
        assert (flags_kind, sizes_kind, name_kind, numbers_kind) == (6, 5, 1, 9)
        assert flags[0] == 6 and next_one == len(body), "not a matrix of doubles"
        rows, columns = struct.unpack("=2i", sizes)
        x = struct.unpack(f"={rows * columns}d", numbers)
        found[name.decode()] = (rows, columns, [list(x[i::rows]) for i in range(rows)])
    return found


def csv_matrices(path):
    found = {}
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    while lines:
        mark, name, rows, columns = lines.pop(0).split()
        assert mark == "#"
        table = [[float(x) for x in lines.pop(0).split(",") if x] for _ in range(int(rows))]
        found[name] = (int(rows), int(columns), table)
    return found


mat, csv = mat_matrices(sys.argv[1]), csv_matrices(sys.argv[2])
assert list(csv) == ["descriptor_E", "descriptor_A", "descriptor_B", "A", "B", "C", "D"], list(csv)
assert csv["descriptor_E"][:2] == (9, 9) and csv["A"][:2] == (5, 5) and csv["B"][:2] == (5, 1)
assert any(any(row) for row in csv["A"][2]), "A is zero"
if mat != csv:
    sys.exit("the MAT file has other matrices than the CSV file")

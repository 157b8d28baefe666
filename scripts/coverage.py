#!/usr/bin/env python3
"""What tests reach in src/, from the counters of gcc --coverage.
SPDX-License-Identifier: BSD-3-Clause

Usage: coverage.py figures TREE COUNTERS LIMITS LEFT    lines and branches; fails below the figures of LIMITS, writes what
                                                        no test reaches to LEFT
       coverage.py tests TREE COUNTERS JUNIT            the fewest seconds of tests that reach nearly all arcs

TREE is the build tree, COUNTERS has a folder of counters for each test (GCOV_PREFIX), JUNIT is ctest's report.
"""
import collections
import functools
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

NOTE, DATA = b"oncg", b"adcg"  # magic words of .gcno and .gcda, little endian
FUNCTION, BLOCKS, ARCS, LINES, COUNTERS = 0x01000000, 0x01410000, 0x01430000, 0x01450000, 0x01A10000
ON_TREE, FAKE = 1, 2  # an arc without a counter; one that stands for a call that does not return
ENOUGH = 0.999  # share of the arcs that the selection of tests has to reach


class Words:
    """A file of gcov, word by word; gcc 12 and later count lengths in bytes."""

    def __init__(self, path, magic):
        with open(path, "rb") as file:
            self.bytes = file.read()
        if self.bytes[:4] != magic:
            raise SystemExit(f"{path}: not of gcov, or of another byte order")
        if self.bytes[4:8][::-1] < b"B2":
            raise SystemExit(f"{path}: of gcc before 12")
        self.at = 16  # magic, version, stamp, checksum

    def word(self):
        (value,) = struct.unpack_from("<I", self.bytes, self.at)
        self.at += 4
        return value

    def text(self):
        length = self.word()
        self.at += length
        return self.bytes[self.at - length : self.at - 1].decode() if length else ""

    def records(self):
        """Tag and length of each record; the next begins where the last one said, whatever was read."""
        while self.at + 8 <= len(self.bytes):
            tag, length = self.word(), self.word()
            if not tag:
                return
            if length >= 1 << 31:  # that many bytes of zeros which are not in the file
                length -= 1 << 32
            end = self.at + max(length, 0)
            yield tag, length
            self.at = end


class Function:
    """Arcs of one function. What the spanning tree leaves out follows from what flows in and out of blocks."""

    def __init__(self):
        self.blocks = 0
        self.arcs = []  # source, destination, flags
        self.lines = []  # block, file, line

    @functools.cached_property
    def order(self):
        """Arcs without counters, each with the others of a block where it is the last unknown one."""
        around = collections.defaultdict(lambda: ([], []))
        for number, (source, destination, _) in enumerate(self.arcs):
            around[source][1].append(number)
            around[destination][0].append(number)
        ends = {0, 1}  # entry and exit, through which calls come and go
        unknown = {n for n, arc in enumerate(self.arcs) if arc[2] & ON_TREE}
        result = []
        work = [block for block in around if block not in ends]
        while unknown and work:
            later = []
            for block in work:
                entering, leaving = around[block]
                missing = [n for n in entering + leaving if n in unknown]
                if len(missing) == 1:
                    (arc,) = missing
                    here, there = (entering, leaving) if arc in entering else (leaving, entering)
                    result.append((arc, there, [n for n in here if n != arc]))
                    unknown.discard(arc)
                elif missing:
                    later.append(block)
            if len(later) == len(work):
                break
            work = later
        return result

    def reached(self, counters):
        """Numbers of the arcs that were taken."""
        counts = [0] * len(self.arcs)
        values = iter(counters)
        for number, arc in enumerate(self.arcs):
            if not arc[2] & ON_TREE:
                counts[number] = next(values, 0)
        for arc, plus, minus in self.order:
            counts[arc] = sum(counts[n] for n in plus) - sum(counts[n] for n in minus)
        return [n for n, count in enumerate(counts) if count > 0 and not self.arcs[n][2] & FAKE]


def read_notes(path):
    """Functions of an object by their number."""
    words = Words(path, NOTE)
    words.text()  # the folder of the compilation
    words.word()
    functions = {}
    function = Function()
    for tag, length in words.records():
        if tag == FUNCTION:
            function = functions[words.word()] = Function()
        elif tag == BLOCKS:
            function.blocks = words.word()
        elif tag == ARCS:
            source = words.word()
            for _ in range((length - 4) // 8):
                function.arcs.append((source, words.word(), words.word()))
        elif tag == LINES:
            block, file = words.word(), ""
            while True:
                line = words.word()
                if not line:
                    file = words.text()
                    if not file:
                        break
                else:
                    function.lines.append((block, file, line))
    return functions


def read_counters(path):
    """Counters of the functions that ran, by number."""
    words = Words(path, DATA)
    result = {}
    number = None
    for tag, length in words.records():
        if tag == FUNCTION and length:
            number = words.word()
        elif tag == COUNTERS and length > 0:
            result[number] = struct.unpack_from(f"<{length // 8}q", words.bytes, words.at)
    return result


def counter_files(folder, tree):
    """Files of counters below a folder: path, name in the build tree."""
    top = os.path.join(folder, os.path.abspath(tree).lstrip("/"))
    for place, _, names in os.walk(top):
        for name in names:
            if name.endswith(".gcda"):
                path = os.path.join(place, name)
                yield path, os.path.relpath(path, top)


def folders(counters):
    return sorted(entry.name for entry in os.scandir(counters) if entry.is_dir())


def all_counters(tree, counters):
    """Counters of all tests together: for each object those of its functions, added."""
    total = collections.defaultdict(dict)
    example = {}
    for test in folders(counters):
        for path, name in counter_files(os.path.join(counters, test), tree):
            example.setdefault(name, path)
            functions = total[name]
            for number, values in read_counters(path).items():
                old = functions.get(number)
                functions[number] = [a + b for a, b in zip(old, values)] if old else list(values)
    return total, example


def write_sum(name, functions, example, work):
    """A file of counters as gcov reads it, with the sums in place of one test's."""
    words = Words(example, DATA)
    out = bytearray(words.bytes[:16])
    number = None
    for tag, length in words.records():
        body = words.bytes[words.at : words.at + max(length, 0)]
        if tag == FUNCTION and length:
            number = words.word()
        if tag == COUNTERS:
            values = functions.get(number)
            if values:
                length, body = 8 * len(values), struct.pack(f"<{len(values)}q", *values)
        out += struct.pack("<Ii", tag, length) + body
    path = os.path.join(work, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(out + b"\0\0\0\0")
    return path


def notes(tree):
    """Notes of all objects made of src/, those that a test has of its own too: path, name in the tree."""
    for place, folders_here, names in os.walk(tree):
        folders_here[:] = [name for name in folders_here if name != "counters"]
        for name in names:
            path = os.path.join(place, name)
            if name.endswith(".gcno") and re.search(r"(^|/)src/", os.path.relpath(path, tree)):
                yield path, os.path.relpath(path, tree)


def ask_gcov(tree, counters):
    """Lines and branches of src/: {file: {line: count}}, {(file, line, n): count}; objects that share a file add up."""
    total, example = all_counters(tree, counters)
    lines = collections.defaultdict(lambda: collections.defaultdict(int))
    branches = collections.defaultdict(int)
    root = os.path.realpath(os.path.join(os.path.dirname(__file__), ".."))
    with tempfile.TemporaryDirectory() as work:
        paths = []
        for note, name in notes(tree):
            os.makedirs(os.path.dirname(os.path.join(work, name)), exist_ok=True)
            os.symlink(os.path.abspath(note), os.path.join(work, name))
            data = name[: -len(".gcno")] + ".gcda"
            if data in total:
                write_sum(data, total[data], example[data], work)
            paths.append(name)
        for first in range(0, len(paths), 50):
            answer = subprocess.run(["gcov", "--json-format", "--stdout", "--branch-probabilities", *paths[first : first + 50]], cwd=work,
                                    capture_output=True, text=True, check=True).stdout
            for report in answer.splitlines():
                report = json.loads(report)
                for file in report["files"]:
                    path = os.path.realpath(os.path.join(report["current_working_directory"], file["file"]))
                    if not path.startswith(root + "/src/"):
                        continue
                    path = os.path.relpath(path, root)
                    seen = collections.Counter()
                    for line in file["lines"]:
                        place = line["line_number"]
                        lines[path][place] += line["count"]
                        for branch in line["branches"]:
                            branches[path, place, seen[place]] += branch["count"]
                            seen[place] += 1
    return lines, branches


def not_reached(lines, branches):
    """Each line that no test reaches, and each that is left in one direction only: kind, place, number, text."""
    texts = {}
    for path in lines:
        with open(path, encoding="utf-8") as file:
            texts[path] = file.read().splitlines()
    for path in sorted(lines):
        for line, count in sorted(lines[path].items()):
            if not count:
                yield "line", path, line, 1, texts[path][line - 1].strip()
    missing = collections.Counter((path, line) for (path, line, _), count in branches.items() if not count)
    for (path, line), number in sorted(missing.items()):
        yield "branch", path, line, number, texts[path][line - 1].strip()


def by_kind(lines, branches, limits, left):
    """How much of what is left is of the kinds that the file names by patterns of text; the first that fits counts."""
    kinds = re.findall(r"^kind ([^:]+): (.+)$", limits, re.M)
    counts = collections.Counter()
    with open(left, "w", encoding="utf-8") as file:
        for what, path, line, number, text in not_reached(lines, branches):
            name = next((name for name, pattern in kinds if re.search(pattern, text)), "other")
            counts[name, what] += number
            file.write(f"{name}\t{what}\t{number}\t{path}:{line}\t{text}\n")
    for name in [name for name, _ in kinds] + ["other"]:
        print(f"    {name}: {counts[name, 'line']} lines, {counts[name, 'branch']} branches")


def tests_by_line(tree, counters, files):
    """Tests that reach each line of code of some files: {(file, line): names}; none where nobody does."""
    result = {}
    functions = {}
    for path, name in notes(tree):
        own = {n: f for n, f in read_notes(path).items() if any(os.path.realpath(file) in files for _, file, _ in f.lines)}
        if own:
            functions[name[: -len(".gcno")]] = own
            for function in own.values():
                result.update(((os.path.realpath(file), line), set()) for _, file, line in function.lines)
    for test in folders(counters):
        for path, name in counter_files(os.path.join(counters, test), tree):
            own = functions.get(name[: -len(".gcda")])
            for number, values in (read_counters(path) if own else {}).items():
                if number not in own:
                    continue
                function = own[number]
                blocks = {block for arc in function.reached(values) for block in function.arcs[arc][:2]}
                for block, file, line in function.lines:
                    if block in blocks:
                        result[os.path.realpath(file), line].add(test)
    return result


def seconds_of(junit):
    """Seconds of each test, of ctest's report."""
    return {case.get("name"): float(case.get("time")) for case in xml.etree.ElementTree.parse(junit).iter("testcase")}


def share(counts):
    counts = list(counts)
    return sum(1 for count in counts if count), len(counts)


def figures(tree, counters, limits, left):
    lines, branches = ask_gcov(tree, counters)
    with open(limits, encoding="utf-8") as file:
        limits = file.read()
    committed = dict(re.findall(r"^(lines|branches) +([0-9.]+)", limits, re.M))
    status = 0
    values = (("lines", (count for file in lines.values() for count in file.values())), ("branches", branches.values()))
    for name, counts in values:
        reached, number = share(counts)
        figure = 100 * reached / max(number, 1)
        print(f"{name:9}{figure:7.2f} %   {reached} of {number}; committed {committed[name]}")
        if figure < float(committed[name]):
            print(f"{name}: below the committed figure")
            status = 1
    by_kind(lines, branches, limits, left)
    return status


def tests(tree, counters, junit):
    functions = {name[: -len(".gcno")]: read_notes(path) for path, name in notes(tree)}
    sets = {}
    for test in folders(counters):
        reached = set()
        for path, name in counter_files(os.path.join(counters, test), tree):
            name = name[: -len(".gcda")]
            if name not in functions:  # of a test's own source
                continue
            for number, values in read_counters(path).items():
                reached.update((name, number, arc) for arc in functions[name][number].reached(values))
        sets[test] = reached
    seconds = seconds_of(junit)
    tests_of = collections.Counter(arc for reached in sets.values() for arc in reached)
    number = len(tests_of)
    chosen, missing = [], set(tests_of)
    while len(missing) > (1 - ENOUGH) * number:
        gain, test = max((len(missing & sets[t]) / (seconds.get(t, 0) + 0.02), t) for t in sets if t not in chosen)
        if not gain:
            break
        chosen.append(test)
        missing -= sets[test]
    print(f"# {number} arcs are reached by {len(sets)} tests in {sum(seconds.get(t, 0) for t in sets):.0f} s; "
          f"{number - len(missing)} by {len(chosen)} of them in {sum(seconds.get(t, 0) for t in chosen):.0f} s")
    print("# test, seconds, arcs, arcs that this one adds to those above it, arcs that no other test reaches")
    have = set()
    others = sorted((t for t in sets if t not in chosen), key=lambda t: -len(sets[t] & missing))
    for rank, test in enumerate(chosen + others):
        if rank == len(chosen):
            print("# not chosen")
        alone = sum(1 for arc in sets[test] if tests_of[arc] == 1)
        print(f"{test}\t{seconds.get(test, 0):.2f}\t{len(sets[test])}\t{len(sets[test] - have)}\t{alone}")
        have |= sets[test]
    return 0


def main(arguments):
    actions = {"figures": (figures, 4), "tests": (tests, 3)}
    if not arguments or arguments[0] not in actions or len(arguments) != 1 + actions[arguments[0]][1]:
        print(__doc__, file=sys.stderr)
        return 2
    return actions[arguments[0]][0](*arguments[1:]) or 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/env python3
"""Changes operators in src/, one at a time, and asks whether the tests see it.
SPDX-License-Identifier: BSD-3-Clause

Usage: mutants.py COPY SEED COUNT TABLE

COPY is a copy of the project with a built tree in COPY/build, SEED chooses the places, TABLE names the survivors that
are argued to be equivalent (tests/mutants.md). For each change the file is compiled anew, and tests are linked and run
one after the other, those of the same room first, until one fails. Prints a line each and the share that was seen.
"""
import json
import os
import random
import re
import subprocess
import sys
import time

# What is changed into what. Blanks belong to operators: the source has clang-format's.
CHANGES = [
    (r" < ", " <= "),
    (r" <= ", " < "),
    (r" > ", " >= "),
    (r" >= ", " > "),
    (r" == ", " != "),
    (r" != ", " == "),
    (r" && ", " || "),
    (r" \|\| ", " && "),
    (r" \+ ", " - "),
    (r" - ", " + "),
    (r" \+= ", " -= "),
    (r" -= ", " += "),
    (r"(?<=[(\s])!(?=[a-z(])", ""),
    (r"(?<![\w.])0\.0(?![\w])", "1.0"),
    (r"(?<![\w.])1\.0(?![\w])", "0.0"),
    (r"(?<![\w.\[])0(?![\w.])", "1"),
    (r"(?<![\w.\[])1(?![\w.])", "0"),
    (r"(?<=return )-(?=\w)", ""),
]
LABELS = {"unit", "reference", "property", "ida", "files", "contact", "fe", "linear", "study", "fmu"}
SLOWEST = 60  # seconds, after which a test counts as failed: changed conditions of loops do not end


def places(root):
    """Every change that could be made: file, line number, new line."""
    for folder, _, names in sorted(os.walk(os.path.join(root, "src"))):
        for name in sorted(names):
            if not name.endswith((".c", ".h")) or "viewer" in folder:
                continue
            path = os.path.join(folder, name)
            with open(path, encoding="utf-8") as file:
                lines = file.read().split("\n")
            comment = False
            for number, line in enumerate(lines):
                comment = comment or line.lstrip().startswith("/*")
                code = not comment and line.startswith(" ") and '"' not in line
                comment = comment and "*/" not in line
                if not code:
                    continue
                end = line.find("/*") if "/*" in line else len(line)
                for old, new in CHANGES:
                    for match in re.finditer(old, line[:end]):
                        yield path, number, line[: match.start()] + new + line[match.end() :]


def tests_of(build):
    """Tests that are a program of their own, which need not be built: name, target, label."""
    answer = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    for test in json.loads(answer.stdout)["tests"]:
        properties = {entry["name"]: entry["value"] for entry in test["properties"]}
        target = test["name"].replace(".", "_", 1)
        command = test.get("command", [target])
        label = properties.get("LABELS", [""])[0]
        if label in LABELS and len(command) == 1 and os.path.basename(command[0]) == target:
            yield test["name"], target, label


def in_order(tests, room, sources):
    """Tests of the room first, then those of its component, the others as the seed has it."""

    def far(test):
        name, _, label = test
        folder = sources.get(name.split(".", 1)[1], "")
        words = set(room.split("/"))
        return (room not in folder, not words & set(folder.split("/")), label not in words, label != "unit")

    return sorted(tests, key=far)


def sources_of_tests(root):
    result = {}
    for folder, _, names in os.walk(os.path.join(root, "tests")):
        for name in names:
            if name.startswith("test_") and name.endswith(".c"):
                result[re.sub(r"^test_(ida_)?", "", name[:-2])] = os.path.relpath(folder, root)
    return result


def run(command, folder, seconds):
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, timeout=seconds, check=False).returncode
    except subprocess.TimeoutExpired:
        return "too long"


def fails(copy, build, target):
    """Whether a test does, or None where it does not compile."""
    if run(["cmake", "--build", build, "--target", target], copy, 1800):
        return None
    return bool(run([os.path.join(build, "tests", target)], os.path.join(build, "tests"), SLOWEST))


def judge(copy, build, path, tests, sources):
    """What becomes of the change that stands in the file now, and the test that saw it."""
    room = os.path.relpath(os.path.dirname(path), os.path.join(copy, "src"))
    for test in in_order(tests, room, sources):
        failed = fails(copy, build, test[1])
        if failed is None:
            return "does not compile", None
        if failed:
            return "seen", test
    return "survived", None


def with_change(path, number, line, ask):
    """An answer while the line is another one."""
    with open(path, encoding="utf-8") as file:
        old = file.read()
    lines = old.split("\n")
    lines[number] = line
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        return ask()
    finally:
        with open(path, "w", encoding="utf-8") as file:
            file.write(old)


def argued(table):
    """Places of the table: (file, text of the changed line)."""
    with open(table, encoding="utf-8") as file:
        rows = re.findall(r"^\| `?(src/[^|`]*)`? \| `([^`]*)` \|", file.read(), re.M)
    return {(path.strip(), line.strip()) for path, line in rows}


def main(arguments):
    if len(arguments) != 4:
        print(__doc__, file=sys.stderr)
        return 2
    copy, seed, count = os.path.realpath(arguments[0]), int(arguments[1]), int(arguments[2])
    build = os.path.join(copy, "build")
    equivalent = argued(arguments[3])
    chance = random.Random(seed)
    everything = list(places(copy))
    tests = list(tests_of(build))
    chance.shuffle(tests)
    sources = sources_of_tests(copy)
    counts = {"seen": 0, "survived": 0, "equivalent": 0, "does not compile": 0}
    print(f"seed {seed}, {count} of {len(everything)} changes, {len(tests)} tests", flush=True)
    sound = set()  # tests that pass without a change; others are left out
    for path, number, line in chance.sample(everything, count):
        with open(path, encoding="utf-8") as file:
            before = file.read().split("\n")[number]
        name = os.path.relpath(path, copy)
        start = time.monotonic()
        while True:
            result, test = with_change(path, number, line, lambda: judge(copy, build, path, tests, sources))
            if result != "seen" or test in sound:
                break
            if fails(copy, build, test[1]):
                print(f"left out, since it fails without a change: {test[0]}", flush=True)
                tests.remove(test)
            else:
                sound.add(test)
        if result == "survived" and (name, line.strip()) in equivalent:
            result = "equivalent"
        counts[result] += 1
        seconds = f"{time.monotonic() - start:.0f} s"
        print(f"{result}\t{name}:{number + 1}\t{before.strip()}\t->\t{line.strip()}\t{test[0] if test else ''}\t{seconds}",
              flush=True)
    asked = counts["seen"] + counts["survived"]
    print(", ".join(f"{number} {name}" for name, number in counts.items()))
    print(f"seen: {100 * counts['seen'] / max(asked, 1):.0f} % of {asked} that are not argued to be equivalent")
    return 0 if counts["seen"] >= 0.9 * asked else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/env python3
"""Changes operators in src/, one at a time, and asks whether the tests see it.
SPDX-License-Identifier: BSD-3-Clause

Usage: mutants.py COPY SEED COUNT TABLE FIRST SECONDS

COPY is a copy of the project in which scripts/coverage.sh has run, SEED chooses the places, TABLE names the survivors
that are argued to be equivalent (tests/mutants.md), FIRST is the number of the first change to be judged. A change is
asked of the tests that reach its line, the quickest first, until one fails or SECONDS of tests have passed, by the run
that counted (the first one in any case). Prints a line each and the share seen.
"""
import collections
import json
import os
import random
import re
import signal
import subprocess
import sys
import time

import coverage

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
SLOWEST = 60  # seconds, after which a test counts as failed: changed conditions of loops do not end

Test = collections.namedtuple("Test", "name command folder environment targets seconds")


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
    """Tests by name; those that run a program of the build tree, which is their target."""
    answer = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, text=True, check=True)
    seconds = coverage.seconds_of(os.path.join(build, "junit.xml"))
    result = {}
    for test in json.loads(answer.stdout)["tests"]:
        properties = {entry["name"]: entry["value"] for entry in test["properties"]}
        command = test.get("command", [])
        targets = [os.path.relpath(word, build) for word in command
                   if word.startswith(build + "/") and os.path.isfile(word) and os.access(word, os.X_OK)]
        if targets:
            environment = dict(entry.split("=", 1) for entry in properties.get("ENVIRONMENT", []))
            environment["GCOV_PREFIX"] = os.path.join(build, "not_counted")
            folder = properties.get("WORKING_DIRECTORY", build)
            result[test["name"]] = Test(test["name"], command, folder, environment, targets, seconds.get(test["name"], SLOWEST))
    return result


def run(command, folder, seconds, environment=None):
    """What a command returns; one that takes too long ends with all that it has started."""
    with subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                          env={**os.environ, **(environment or {})}, start_new_session=True) as process:
        try:
            return process.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return "too long"


def fails(build, test):
    """Whether a test does, or None where it does not compile."""
    if run(["ninja", "-C", build, *test.targets], build, 1800):
        return None
    return bool(run(test.command, test.folder, SLOWEST, test.environment))


def judge(build, tests, enough):
    """What becomes of the change that stands in the file now, and the test that saw it."""
    spent = 0.0
    for test in tests:
        spent += test.seconds
        if spent > enough and test is not tests[0]:
            break
        failed = fails(build, test)
        if failed is None:
            return "does not compile", None
        if failed:
            return "seen", test
    return "survived", None


def assembly(build, path):
    """What the compiler makes of a file with optimisation, without counters, in each library that has it."""
    answer = subprocess.run(["ninja", "-C", build, "-t", "compdb"], capture_output=True, text=True, check=True)
    result = []
    for entry in json.loads(answer.stdout):
        if os.path.realpath(os.path.join(entry["directory"], entry["file"])) == path and " -c " in entry["command"]:
            command = re.sub(r" (--coverage|-fprofile\S+|-M\w+( \S+\.d)?|-o \S+|-O0)(?= )", "", entry["command"])
            command = re.sub(r" -M[TFD]+ \S+", "", command)
            result.append(subprocess.run(command.replace(" -c ", " -O2 -S -o - "), shell=True, cwd=entry["directory"],
                                         capture_output=True, text=True, check=True).stdout)
    return result


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
        rows = re.findall(r"^\| `?(src/[^|`]*)`? \| `(.*?)` \|", file.read(), re.M)
    return {(path.strip(), line.replace("\\|", "|").strip()) for path, line in rows}


def in_order(tests, reached, path, number):
    """Tests that reach a line, the quickest first. Of a line without code, a table's: those that reach the file."""
    names = reached.get((path, number + 1))
    if names is None:
        names = set().union(*(names for (file, _), names in reached.items() if file == path))
    return sorted((tests[name] for name in names if name in tests), key=lambda test: (test.seconds, test.name))


def main(arguments):
    if len(arguments) != 6:
        print(__doc__, file=sys.stderr)
        return 2
    copy, seed, count = os.path.realpath(arguments[0]), int(arguments[1]), int(arguments[2])
    first, enough = int(arguments[4]), float(arguments[5])
    build = os.path.join(copy, "build", "coverage")
    equivalent = argued(arguments[3])
    everything = list(places(copy))
    chosen = random.Random(seed).sample(everything, count)
    tests = tests_of(build)
    reached = coverage.tests_by_line(build, os.path.join(build, "counters"), {path for path, _, _ in chosen})
    counts = collections.Counter()
    print(f"seed {seed}, {count} of {len(everything)} changes, {len(tests)} tests", flush=True)
    sound = set()  # tests that pass without a change; others are left out
    for rank, (path, number, line) in enumerate(chosen[first - 1 :], first):
        with open(path, encoding="utf-8") as file:
            before = file.read().split("\n")[number]
        name = os.path.relpath(path, copy)
        start = time.monotonic()
        while True:
            order = in_order(tests, reached, path, number)
            result, test = with_change(path, number, line, lambda: judge(build, order, enough)) if order else ("not reached", None)
            if result != "seen" or test.name in sound:
                break
            if fails(build, test):
                print(f"left out, since it fails without a change: {test.name}", flush=True)
                del tests[test.name]
            else:
                sound.add(test.name)
        if result in ("survived", "not reached"):
            if (name, line.strip()) in equivalent:
                result = "equivalent"
            elif name.endswith(".c") and assembly(build, path) == with_change(path, number, line, lambda: assembly(build, path)):
                result = "same code"
        counts[result] += 1
        seconds = f"{time.monotonic() - start:.0f} s"
        print(f"{rank}\t{result}\t{name}:{number + 1}\t{before.strip()}\t->\t{line.strip()}\t{test.name if test else len(order)}\t{seconds}",
              flush=True)
    asked = counts["seen"] + counts["survived"] + counts["not reached"]
    print(", ".join(f"{number} {name}" for name, number in counts.items()))
    print(f"seen: {100 * counts['seen'] / max(asked, 1):.0f} % of {asked} that are not equivalent")
    return 0 if counts["seen"] >= 0.9 * asked else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

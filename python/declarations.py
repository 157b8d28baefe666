# SPDX-License-Identifier: BSD-3-Clause
"""Reads the public headers: declarations for cffi, and for each function its parameters and its
text.

    declarations.py INCLUDE_DIR...     writes the declarations to standard output

The compiler's preprocessor expands the headers; comments come from their texts, since the header
is the specification of a function.
"""
from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

#: The headers of the components that the package wraps.
HEADERS = ("mbsrank/mbsrank.h", "mbsrank/driver.h", "mbsrank/simulation.h",
           "mbsrank/sensitivity.h", "mbsrank/files.h")

#: Headers of components that may be missing.
OPTIONAL = {"contact": ("mbsrank/contact.h",), "linear": ("mbsrank/linear.h",),
            "fmu": ("mbsrank/fmu.h",), "fe": ("mbsrank/fe.h", "mbsrank/sid.h")}

#: What trampolines return to C where a function of the caller's raises.
EXCEPTION = -32000


@dataclass
class Function:
    """A public function: result, (type, name) of its parameters, and the comment above it."""

    name: str
    result: str
    parameters: list[tuple[str, str]]
    text: str = ""


@dataclass
class Interface:
    """All that the headers declare."""

    declarations: str = ""
    components: tuple[str, ...] = ()
    constants: dict[str, int] = field(default_factory=dict)
    functions: dict[str, Function] = field(default_factory=dict)
    callbacks: dict[str, str] = field(default_factory=dict)


def _compiler() -> list[str]:
    return os.environ.get("CC", "cc").split()


def headers(components: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Those that are wrapped where these components are there."""
    return HEADERS + tuple(one for name in components for one in OPTIONAL[name])


def includes(components: tuple[str, ...] = ()) -> str:
    """A source of C that has them."""
    return "".join(f"#include <{name}>\n" for name in headers(components))


def _preprocess(folders: list[str], flags: list[str], source: str) -> str:
    """The headers without those of the system, whose only type is size_t."""
    with tempfile.TemporaryDirectory() as stubs:
        Path(stubs, "stddef.h").write_text("")
        command = _compiler() + ["-E", "-P", "-nostdinc", "-D__attribute__(x)=", "-I", stubs]
        command += [f"-I{folder}" for folder in folders] + flags + ["-x", "c", "-"]
        run = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    if run.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{run.stderr}")
    return run.stdout


def _constants(folders: list[str], source: str) -> dict[str, int]:
    """Macros that are whole numbers."""
    found = {}
    for line in _preprocess(folders, ["-dM"], source).splitlines():
        match = re.fullmatch(r"#define (MBSR_\w+) \(?(-?\d+)u?\)?", line)
        if match:
            found[match[1]] = int(match[2])
    return found


def _parameter(text: str) -> tuple[str, str]:
    """`const double point[3]` is ("const double[3]", "point")."""
    text = " ".join(text.split())
    if "(*" in text:
        name = re.search(r"\(\*\s*(\w+)\)", text)[1]
        return text.replace(name, "", 1), name
    match = re.fullmatch(r"(.*?)(\w+)\s*((?:\[[^\]]*\])*)", text)
    return match[1].strip() + match[3], match[2]


def _split(text: str) -> list[str]:
    parts, depth, last = [], 0, 0
    for at, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append(text[last:at])
            last = at + 1
    return [part for part in [*parts, text[last:]] if part.strip() and part.strip() != "void"]


def _functions(declarations: str) -> dict[str, Function]:
    found = {}
    for statement in re.split(r";\s*\n", re.sub(r"\{[^{}]*\}", "", declarations)):
        match = re.fullmatch(r"\s*([\w\s*]+?)\b(mbsr_\w+)\s*\((.*)\)\s*", statement, re.S)
        if match and not match[1].strip().startswith("typedef"):
            parameters = [_parameter(part) for part in _split(match[3])]
            found[match[2]] = Function(match[2], " ".join(match[1].split()), parameters)
    return found


def _plain(comment: str) -> str:
    lines = [re.sub(r"^\s*\*? ?", "", line) for line in comment.splitlines()]
    return "\n".join(lines).strip()


def _texts(folders: list[str], functions: dict[str, Function]) -> None:
    """Gives each function the comment above it, and the one behind it on its line."""
    names = {name: path for folder in folders for path in Path(folder, "mbsrank").glob("*.h")
             for name in [path.name]}
    token = re.compile(r"/\*(.*?)\*/|MBSR_API\b[^;]*?\b(mbsr_\w+)\s*\([^;]*;([ \t]*/\*(.*?)\*/)?",
                       re.S)
    for path in names.values():
        above = ""
        for match in token.finditer(path.read_text(encoding="utf-8")):
            if match[2] is None:
                above = re.sub(r"^----.*?(\n|$)", "", _plain(match[1])).strip()
            elif match[2] in functions:
                functions[match[2]].text = "\n".join(filter(None, [above, _plain(match[4] or "")]))


def _trampolines(declarations: str) -> dict[str, str]:
    """Named function types: their result, parameters in brackets."""
    pattern = r"typedef\s+(\w+)\s*\(\s*\*\s*(mbsr_\w+_fn)\s*\)\s*(\([^;]*\))\s*;"
    found = re.findall(pattern, declarations)
    return {name: f"{result} mbsrank_{name}{parameters}" for result, name, parameters in found
            if re.match(r"\(\s*void \*", parameters)}


#: Functions in the tables of elements that are written in Python.
TABLE_FUNCTIONS = {
    "mbsrank_force_evaluate": "int mbsrank_force_evaluate(const mbsr_force_args *args)",
    "mbsrank_force_energy": "int mbsrank_force_energy(const mbsr_force_args *args, double *energy)",
}


def read(folders: list[str], components: tuple[str, ...] = ()) -> Interface:
    """Reads the headers in these folders, with those of these optional components."""
    source = includes(components)
    text = _preprocess(folders, ["-DMBSR_API="], source)
    text = re.sub(r"static inline [^{]*\{[^}]*\}", "", text)
    interface = Interface(components=components, constants=_constants(folders, source), functions=_functions(text),
                          callbacks=_trampolines(text))
    interface.callbacks.update(TABLE_FUNCTIONS)
    _texts(folders, interface.functions)
    macros = "".join(f"#define {name} {value}\n" for name, value in interface.constants.items())
    python = "".join(f'extern "Python" {one};\n' for one in interface.callbacks.values())
    interface.declarations = f"{macros}{text}\n{python}"
    return interface


if __name__ == "__main__":
    sys.stdout.write(read(sys.argv[1:]).declarations)

# SPDX-License-Identifier: BSD-3-Clause
"""Writes what the package takes from the headers: _interface.py with each function's parameters and text,
and stubs with the types of the constructors of joints, inertias, forces and closures."""
from __future__ import annotations

import pprint
from pathlib import Path

#: Values that constructors make: the module of the package, and the class there.
VALUES = {
    "mbsr_joint": ("joint", "Joint"),
    "mbsr_inertia": ("inertia", "Inertia"),
    "mbsr_force_def": ("force", "Force"),
    "mbsr_closure_def": ("closure", "Closure"),
}

_TYPES = {
    "int": "int", "double": "float", "const char *": "str | None",
    "const mbsr_frame *": "FrameLike", "mbsr_frame": "FrameLike",
    "mbsr_planar_frame": "Sequence[float]", "mbsr_table *": "Table",
    "mbsr_inertia": "Inertia", "mbsr_joint": "Joint",
}


def python_name(result: str, name: str) -> str:
    """mbsr_joint_revolute is revolute in mbsrank.joint."""
    prefix = f"mbsr_{VALUES[result][0]}_"
    return name[len(prefix):] if name.startswith(prefix) else name.removeprefix("mbsr_")


def constructors(functions) -> dict[str, list]:
    """The constructors of each module."""
    found = {module: [] for module, _ in VALUES.values()}
    for one in functions:
        if one.result in VALUES and "default" not in one.name:
            found[VALUES[one.result][0]].append(one)
    return found


def _type(kind: str) -> str:
    if kind in _TYPES:
        return _TYPES[kind]
    if kind.endswith("_fn"):
        return "Callable[..., Any] | Table"
    if kind.startswith(("const double", "const int")):
        return "ArrayLike | None"
    return "Mapping[str, Any] | Any"


def _stub(one) -> str:
    parameters = ", ".join(f"{name}: {_type(kind)} = ..." if kind.endswith("*") or "[" in kind
                           else f"{name}: {_type(kind)}"
                           for kind, name in one.parameters if kind != "void *")
    # a parameter with a default may be followed by others without one: these get one too
    seen, parts = False, []
    for part in filter(None, parameters.split(", ")):
        seen = seen or part.endswith("= ...")
        parts.append(part if not seen or part.endswith("= ...") else f"{part} = ...")
    return (f"def {python_name(one.result, one.name)}({', '.join(parts)}) -> "
            f"{VALUES[one.result][1]}: ...\n")


def write(interface, folder: Path) -> None:
    """Writes _interface.py and the stubs into the folder of the package."""
    table = {one.name: (one.result, tuple(one.parameters), one.text)
             for one in interface.functions.values()}
    head = "# Made from the public headers by stubs.py.\n"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "_interface.py").write_text(
        f'"""What the headers say."""\n{head}FUNCTIONS = {pprint.pformat(table, width=110)}\n'
        f"CALLBACKS = {pprint.pformat(interface.callbacks, width=110)}\n", encoding="utf-8")
    for module, ones in constructors(interface.functions.values()).items():
        text = (f"{head}from typing import Any, Callable, Mapping, Sequence\n\n"
                "from numpy.typing import ArrayLike\n\n"
                "from ._values import Closure, Force, FrameLike, Inertia, Joint, Table\n\n")
        extra = folder / f"{module}.pyi.in"
        (folder / f"{module}.pyi").write_text(
            text + "".join(_stub(one) for one in ones)
            + (extra.read_text() if extra.exists() else ""), encoding="utf-8")

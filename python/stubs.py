# SPDX-License-Identifier: BSD-3-Clause
"""Writes what the package takes from the headers: _interface.py with each function's parameters
and text, and stubs with the types of the constructors of joints, inertias, forces and closures."""
from __future__ import annotations

import ast
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
        serves = not any(kind.startswith("const mbsr_") and kind.endswith("_table *")
                         or kind == "mbsr_inertia_fn" for kind, _ in one.parameters)
        if one.result in VALUES and "default" not in one.name and serves:
            found[VALUES[one.result][0]].append(one)
    return found


def _type(kind: str) -> str:
    if kind in _TYPES:
        return _TYPES[kind]
    if kind.endswith("_fn"):
        return "Callable[..., Any] | Table | None"
    if kind.startswith(("const double", "const int")):
        return "ArrayLike | None"
    return "Mapping[str, Any] | Any"


def _stub(one) -> str:
    """A constructor as _values.constructor makes it: pointers at the end may be left out."""
    taken = [(kind, name) for kind, name in one.parameters if kind != "void *"]
    free = len(taken)
    while free and (taken[free - 1][0][-1] in "*]" or taken[free - 1][0].endswith("_fn")):
        free -= 1
    parts = [f"{name}: {_type(kind)}" + (" = ..." if k >= free else "")
             for k, (kind, name) in enumerate(taken)]
    name, result = python_name(one.result, one.name), VALUES[one.result][1]
    return f"def {name}({', '.join(parts)}) -> {result}: ...\n"


def _by_hand(path: Path) -> dict[str, str]:
    """What a module defines itself, in the place of the constructors of the same name."""
    found = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef) and node.name[0] != "_":
            found[node.name] = (f"def {node.name}({ast.unparse(node.args)}) -> "
                                f"{ast.unparse(node.returns)}: ...\n")
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
            found.update({one.id: f"{one.id}: int\n" for one in node.targets[0].elts})
    return found


def write(interface, folder: Path) -> None:
    """Writes _interface.py and the stubs into the folder of the package."""
    table = {one.name: (one.result, tuple(one.parameters), one.text)
             for one in interface.functions.values()}
    head = "# Made from the public headers by stubs.py.\n"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "_interface.py").write_text(
        f'"""What the headers say."""\n{head}FUNCTIONS = {pprint.pformat(table, width=110)}\n'
        f"COMPONENTS = {interface.components!r}\n"
        f"CALLBACKS = {pprint.pformat(interface.callbacks, width=110)}\n", encoding="utf-8")
    for module, ones in constructors(interface.functions.values()).items():
        by_name = {python_name(one.result, one.name): _stub(one) for one in ones}
        by_name.update(_by_hand(Path(__file__).with_name("mbsrank") / f"{module}.py"))
        text = (f"{head}from typing import Any, Callable, Mapping, Sequence\n\n"
                "from numpy.typing import ArrayLike\n\n"
                "from ._core import ForceBody\n"
                "from ._values import Closure, Force, FrameLike, Inertia, Joint, Table\n\n")
        (folder / f"{module}.pyi").write_text(text + "".join(by_name.values()), encoding="utf-8")

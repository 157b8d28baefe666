# SPDX-License-Identifier: BSD-3-Clause
"""What the package declares is what the headers say."""
import inspect
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import mbsrank as mb
from mbsrank._interface import COMPONENTS, FUNCTIONS

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import declarations  # noqa: E402

FOLDERS = os.environ["MBSRANK_INCLUDE"].split(os.pathsep)


def headers():
    """The texts of the headers that are wrapped, and of those that they include, without
    comments."""
    texts, ahead = {}, list(declarations.headers(COMPONENTS))
    while ahead:
        name = ahead.pop()
        if name in texts:
            continue
        path = next(p for p in (Path(folder, name) for folder in FOLDERS) if p.exists())
        texts[name] = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)
        ahead += re.findall(r"#include <(mbsrank/\w+\.h)>", texts[name])
    return texts


def c_program(source):
    """What a program of C prints."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "a.c").write_text(source, encoding="utf-8")
        subprocess.run([*os.environ.get("CC", "cc").split(), "-o", f"{folder}/a", f"{folder}/a.c",
                        *(f"-I{one}" for one in FOLDERS)], check=True)
        return subprocess.run([f"{folder}/a"], check=True, capture_output=True, text=True).stdout


class Declarations(unittest.TestCase):
    def test_every_public_function_is_there(self):
        names = {name for text in headers().values()
                 for name in re.findall(r"MBSR_API\b[^;]*?\b(mbsr_\w+)\s*\(", text)}
        self.assertGreater(len(names), 300)
        self.assertEqual(names, set(FUNCTIONS))
        for name in names:
            self.assertTrue(hasattr(mb.lib, name), name)

    def test_parameters_are_those_of_the_headers(self):
        text = " ".join(" ".join(headers().values()).split())
        for name, (_, parameters, document) in FUNCTIONS.items():
            found = re.search(rf"MBSR_API [^;(]*\b{name} ?\(([^;]*)\) ?;", text)
            self.assertIsNotNone(found, name)
            for _, parameter in parameters:
                self.assertRegex(found[1], rf"\b{parameter}\b", name)
            self.assertEqual(found[1].strip() == "void", not parameters, name)
            self.assertTrue(document, f"{name} has no text")

    def test_constants_and_sizes_are_those_of_the_compiler(self):
        text = "".join(headers().values())
        constants = sorted(set(re.findall(r"\b(MBSR_[A-Z0-9_]+)\b", text)))
        constants = [one for one in constants if isinstance(getattr(mb.lib, one, None), int)]
        structs = sorted(set(re.findall(r"\}\s*(mbsr_\w+);", text)))
        structs += ["mbsr_joint", "mbsr_force_def", "mbsr_closure_def"]
        self.assertGreater(len(constants), 100)
        self.assertGreater(len(structs), 30)
        lines = [f'printf("%lld\\n", (long long)({one}));' for one in constants]
        lines += [f'printf("%zu\\n", sizeof({one}));' for one in structs]
        includes = declarations.includes(COMPONENTS)
        printed = c_program(f"{includes}#include <stdio.h>\nint main(void) {{\n"
                            + "\n".join(lines) + "\nreturn 0;\n}\n").split()
        here = [getattr(mb.lib, one) for one in constants]
        here += [mb.ffi.sizeof(one) for one in structs]
        names = [*constants, *structs]
        self.assertEqual(dict(zip(names, map(int, printed))), dict(zip(names, here)))

    def test_all_that_is_public_is_documented_and_typed(self):
        count = 0
        for name in mb.__all__:
            one = getattr(mb, name)
            if not (inspect.isclass(one) or inspect.isfunction(one)):
                continue
            self.assertTrue(one.__doc__, name)
            members = inspect.getmembers(one, inspect.isfunction) if inspect.isclass(one) else []
            for member, function in members:
                if member[0] == "_" or not function.__module__.startswith("mbsrank"):
                    continue
                count += 1
                self.assertTrue(function.__doc__, f"{name}.{member}")
                self.assertIn("return", function.__annotations__, f"{name}.{member}")
        self.assertGreater(count, 60)

    def test_constructors_have_the_texts_of_the_headers(self):
        for module in (mb.joint, mb.inertia, mb.force, mb.closure):
            for name in module.__all__:
                if name.islower():
                    self.assertTrue(getattr(module, name).__doc__, f"{module.__name__}.{name}")


if __name__ == "__main__":
    unittest.main()

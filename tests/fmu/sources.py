"""Source FMUs, compiled as an importer would and held against the shared object that comes with them: sources.py FOLDER COMPILER.
Nothing but the sources that the description names, a C compiler and the mathematical library is used. Without vector types, by
tcc, which has C11 without atomics and complex numbers and takes a tenth of the time, or, where it is missing, by COMPILER as it
is (GNU's C); with MBSR_TEST_LONG=1 by all of these, in strict C11 and with vector types too.
SPDX-License-Identifier: BSD-3-Clause"""
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
import zipfile

from importer import Instance, Unit

folder, compiler = sys.argv[1:3]
objects = {}  # by command, a source's name and text: what FMUs have in common is compiled once
vectors = (compiler, "-O0", "-Wall", "-Wextra", "-Wno-psabi", "-Werror", "-fPIC")
plain = (*vectors, "-DMBSR_WITHOUT_VECTORS")
strict = (*plain, "-std=c11", "-pedantic-errors")
small = (shutil.which("tcc"), "-std=c11", "-Wall", "-Werror", "-DMBSR_WITHOUT_VECTORS")


def sources_of(archive):
    """The names that the description lists: FMI 3.0 beside the sources, FMI 2.0 in each kind."""
    if "sources/buildDescription.xml" in archive.namelist():
        root = xml.fromstring(archive.read("sources/buildDescription.xml"))
        assert root.get("fmiVersion") == "3.0"
        sets = root.findall("BuildConfiguration/SourceFileSet")
        assert len(sets) == 1 and sets[0].get("language") == "C11"
        defined = sets[0].findall("PreprocessorDefinition")
        assert [(d.get("name"), d.get("optional")) for d in defined] == [("FMI3_OVERRIDE_FUNCTION_PREFIX", "true")]
        return [file.get("name") for file in sets[0].findall("SourceFile")]
    root = xml.fromstring(archive.read("modelDescription.xml"))
    lists = [[file.get("name") for file in kind.findall("SourceFiles/File")]
             for kind in root if kind.tag in ("ModelExchange", "CoSimulation")]
    assert lists and all(names == lists[0] for names in lists)
    return lists[0]


def compile_source(source, to, *command):
    subprocess.run([*command, "-c", source.name, "-o", to], cwd=source.parent, check=True)


def own_library(command):
    """What tcc's code calls."""
    if command != small:
        return ()
    said = subprocess.run([small[0], "-print-search-dirs"], check=True, capture_output=True, text=True).stdout
    return [line.strip() for line in said.splitlines() if line.strip().endswith("libtcc1.a")]


def compile_unit(path, work, *command):
    """The shared object of the sources, in the place of the one that the archive has."""
    with zipfile.ZipFile(path) as archive:
        names, base = sources_of(archive), work / path.stem
        archive.extractall(base)
        listed = {"sources/" + name for name in names}
        there = {n for n in archive.namelist() if n.startswith("sources/") and n.endswith(".c")}
        assert listed == there and len(listed) == len(names), "what is listed is not what is there"

        keys = {name: (command, name, archive.read("sources/" + name)) for name in names}
        new = [name for name in names if keys[name] not in objects]

        def compile_some(k, some):
            to = base / f"objects{k}"
            to.mkdir()
            subprocess.run([*command, "-DFMI2_OVERRIDE_FUNCTION_PREFIX", "-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-c",
                            *(base / "sources" / name for name in some)], cwd=to, check=True)
            objects.update({keys[name]: to / (name[:-1] + "o") for name in some})

        count = os.cpu_count()  # of processes, each for many sources: their start takes most of the time
        with concurrent.futures.ThreadPoolExecutor(count) as pool:
            list(pool.map(compile_some, range(count), (new[k::count] for k in range(min(count, len(new))))))
        made = [objects[keys[name]] for name in names]
        shared = work / (path.stem + ".so")
        subprocess.run([compiler, "-shared", "-Wl,-z,defs,-z,noexecstack", "-o", shared, *made, *own_library(command), "-lm"], check=True)
        to = work / path.name
        with zipfile.ZipFile(to, "w") as copy:
            for entry in (name for name in archive.namelist() if not name.startswith("sources/")):
                data = shared.read_bytes() if entry.startswith("binaries/") else archive.read(entry)
                copy.writestr(entry, data)
    return to, shared


def only_of_c11(base):
    """Headers that the sources include whatever is defined are those of C11."""
    c11 = set("assert complex ctype errno fenv float inttypes limits locale math setjmp signal stdalign stdarg stdatomic stdbool stddef "
              "stdint stdio stdlib stdnoreturn string time uchar wchar wctype".split())
    depth, seen = 0, set()
    for line in (base / "sources" / "mbsrank_set.h").read_text().splitlines():
        depth += line.startswith("#if") - line.startswith("#endif")
        if line.startswith("#include <") and depth == 1:  # the guard's
            seen.add(line[len("#include <"):line.index(".h>")])
    assert seen and seen <= c11, f"{seen - c11} are not of C11"


def prefixed(base, work):
    """Functions of the standard begin with the identifier where nothing else is said: by a macro, or by the header of an
    importer, which declares and names them."""
    to = work / "prefixed.o"
    source, header = base / "sources" / "fmu_fmi3.c", base / "sources" / "fmi3Functions.h"
    for options, right in (((), "arm_fmi3"), (("-DFMI3_FUNCTION_PREFIX=",), "fmi3"), (("-DFMI3_FUNCTION_PREFIX=my_",), "my_fmi3")):
        compile_source(source, to, *vectors, *options)
        names = [name for name in exported(to) if "fmi3" in name]
        assert names and all(name.startswith(right) for name in names), f"{options}: {names[:3]}"
    declared = (base / "sources" / "fmu" / "fmi3_functions.h").read_text()
    header.write_text(declared.replace("MBSRI_FMI3_FUNCTIONS_H", "OF_AN_IMPORTER")
                      .replace("fmi3Status)\nfmi3DoStep(", "fmi3Status)\nimporters_fmi3DoStep("))
    source.write_text(source.read_text().replace("fmi3Status fmi3DoStep(", "fmi3Status importers_fmi3DoStep("))
    compile_source(source, to, *vectors)
    header.unlink()
    assert "importers_fmi3DoStep" in exported(to) and "fmi3GetVersion" in exported(to), "an importer's header"


def co_simulate(unit):
    one = Instance(unit, False)
    assert one.handle, one.log
    one.initialize()
    for k in range(50):
        one.step(k * 0.01, 0.01)
    outputs = [v for v in unit.description.variables if v.causality == "output"]
    if unit.name.startswith("arm"):  # steps of another kind by the error
        outputs = [v for v in outputs if v.name.endswith((".q", ".u"))]
    values = one.get(outputs)
    one.free()
    return values


def exchange(unit):
    """x' at the start and beside it."""
    one = Instance(unit, True)
    assert one.handle, one.log
    one.initialize()
    one.update_states()
    one.call("EnterContinuousTimeMode")
    x = one.numbers("GetContinuousStates", len(unit.description.states))
    values = one.derivatives(0.0, x) + one.derivatives(0.1, [v + 0.01 for v in x])
    one.free()
    return values


def exported(shared):
    listed = subprocess.run(["nm", "-g", "--defined-only", *(["-D"] if shared.suffix == ".so" else []), shared], check=True, capture_output=True, text=True).stdout
    return [line.split()[-1] for line in listed.splitlines()]


ways = [small if small[0] else plain]
if os.environ.get("MBSR_TEST_LONG") == "1":
    ways = [*ways, *(way for way in (plain, strict, vectors) if way not in ways)]
with tempfile.TemporaryDirectory() as name:
    work, runs = pathlib.Path(name), 0
    units = sorted(pathlib.Path(folder).glob("*_sources[23].fmu"))
    for path, command in ((path, command) for command in ways for path in units):
        version = path.stem[-1]
        made, shared = compile_unit(path, work, *command)
        names = exported(shared)
        if command == small:  # which does not hide names
            names = [name for name in names if name.startswith("fmi")]
        assert len(names) == (44 if version == "2" else 75)
        pair = Unit(made), Unit(path)
        for run in (co_simulate, exchange):
            own, theirs = (run(unit) for unit in pair)
            assert own and len(own) == len(theirs)
            worst = max(abs(a - b) / (1.0 + abs(b)) for a, b in zip(own, theirs))
            by_error = run is co_simulate and path.stem.startswith("arm")
            assert worst < (1e-4 if by_error else 1e-9), f"{path.stem}, {run.__name__}: differs by {worst}"
            runs += 1
        for unit in pair:
            unit.close()
    only_of_c11(work / "arm_sources3")
    prefixed(work / "arm_sources3", work)
    assert runs == 12 * len(ways)
print(f"{runs} runs, {len(objects)} sources compiled")

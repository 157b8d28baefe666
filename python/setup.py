# SPDX-License-Identifier: BSD-3-Clause
"""Builds the package against an installed libmbsrank.

Its components contact, linear, fmu and fe are wrapped where they are there. It is found by pkg-config, or in the folder that MBSRANK_PREFIX names. For a build tree
MBSRANK_INCLUDE and MBSRANK_LIBRARIES list folders.
"""
import os
import subprocess
import sys
from pathlib import Path

from cffi import FFI
from setuptools import setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import declarations  # noqa: E402
import stubs  # noqa: E402

COMPONENTS = ["mbsrank_files", "mbsrank_ida", "mbsrank"]


def pkg_config(what: str) -> list[str]:
    """What pkg-config says of the components, or why it cannot."""
    environment = dict(os.environ)
    prefix = environment.get("MBSRANK_PREFIX")
    if prefix:
        folders = [str(path) for path in Path(prefix).glob("lib/**/pkgconfig")]
        environment["PKG_CONFIG_PATH"] = os.pathsep.join(folders)
    command = ["pkg-config", what, *COMPONENTS]
    try:
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise SystemExit("mbsrank: pkg-config is not installed") from error
    if run.returncode:
        raise SystemExit("mbsrank: libmbsrank with its components files and ida is not installed "
                         f"where pkg-config or MBSRANK_PREFIX look:\n{run.stderr}")
    return run.stdout.split()


def folders() -> tuple[list[str], list[str]]:
    """Folders of headers and of libraries."""
    if "MBSRANK_INCLUDE" in os.environ:
        return tuple(os.environ[name].split(os.pathsep)
                     for name in ("MBSRANK_INCLUDE", "MBSRANK_LIBRARIES"))
    headers = [pkg_config(f"--variable={name}") for name in ("includedir", "libdir")]
    return tuple(list(dict.fromkeys(each)) for each in headers)


INCLUDE, LIBRARIES = folders()
OPTIONAL = tuple(name for name in declarations.OPTIONAL for folder in LIBRARIES
                 if any(Path(folder).glob(f"libmbsrank_{name}.*")))
INTERFACE = declarations.read(INCLUDE, OPTIONAL)


def module():
    """The extension mbsrank._c, which has the whole interface of C."""
    ffi = FFI()
    ffi.cdef(INTERFACE.declarations)
    libraries = [f"mbsrank_{name}" for name in OPTIONAL] + COMPONENTS
    ffi.set_source("mbsrank._c", declarations.includes(OPTIONAL), include_dirs=INCLUDE,
                   library_dirs=LIBRARIES, runtime_library_dirs=LIBRARIES, libraries=libraries)
    return ffi.distutils_extension(os.environ.get("MBSRANK_BUILD", str(HERE / "build")))


class Build(build_ext):
    """Writes what the headers say of each function, and the types of the constructors, besides."""

    def run(self):
        super().run()
        to = HERE / "mbsrank" if self.inplace else Path(self.build_lib) / "mbsrank"
        stubs.write(INTERFACE, to)


def version() -> str:
    """Of the headers."""
    constants = INTERFACE.constants
    return ".".join(str(constants[f"MBSR_VERSION_{part}"]) for part in ("MAJOR", "MINOR", "PATCH"))


setup(
    name="mbsrank",
    version=version(),
    description="O(N) dynamics of multibody systems, bodies without mass included",
    license="BSD-3-Clause",
    packages=["mbsrank"],
    package_data={"mbsrank": ["py.typed", "*.pyi"]},
    ext_modules=[module()],
    cmdclass={"build_ext": Build},
    python_requires=">=3.9",
    install_requires=["cffi", "numpy"],
    zip_safe=False,
)

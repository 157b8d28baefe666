# SPDX-License-Identifier: BSD-3-Clause
"""Models from URDF, xacro, MJCF and SDF, and back as MJCF."""
from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Iterable, Mapping

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, encoded, fail, given, plain, taken, text, view
from .model import Data, Model, _create

_KINDS = ("fixed", "hinge", "slide", "ball", "free")


class _Loader:
    """Reads the files that a model names: from its folder, `meshes` beside that, and folders
    named."""

    def __init__(self, home: Path, folders: Iterable[str | os.PathLike]):
        self._home = home
        roots = [home, home.parent / "meshes", *map(Path, folders)]
        self._roots = [os.path.realpath(one) for one in roots]
        self._kept: list = []

    def __call__(self, path, content, size):
        # paths begin with the folder of the model, as the name that was given to the reader does
        where = os.path.realpath(ffi.string(path).decode())
        if not any(os.path.commonpath([where, root]) == root for root in self._roots):
            return errno.EACCES
        try:
            data = Path(where).read_bytes()
        except OSError as error:
            return error.errno or 1
        self._kept.append(ffi.from_buffer("char[]", data))
        content[0], size[0] = self._kept[-1], len(data)
        return 0


class File(Owner):
    """What a file has: `model`, and beside it joints, sites, actuators, sensors, keys (named
    states), shapes and findings, as lists of records; q0 (nq): as drawn; control (actuators):
    their inputs, to be written."""

    def __init__(self, source: str | os.PathLike, *, folders: Iterable[str | os.PathLike] = (),
                 packages: Mapping[str, str] | None = None,
                 arguments: Mapping[str, str] | None = None, **options):
        path = Path(source)
        content = path.read_bytes()
        keep: list = []
        define = _values.options("mbsr_file_opt", options, keep, "read")
        folders = [*folders, *(packages or {}).values()]
        define.load, define.user = _values.callback("mbsr_file_load_fn",
                                                    _Loader(path.parent, folders), keep)
        self._list(define, "packages", "package", "mbsr_file_package", packages, "folder", keep)
        self._list(define.xacro, "arguments", "argument", "mbsr_xacro_argument", arguments, "value",
                   keep)
        pointer = ffi.from_buffer("char[]", content)
        made = _create("mbsr_file", lib.mbsr_file_read, pointer, len(content),
                       str(path).encode(), define)
        self._handle = Handle(made, lib.mbsr_file_destroy)
        model = lib.mbsr_file_take_model(made)
        self.model = Model._of(model, self._handle)
        self._read(made)

    @staticmethod
    def _list(define, count, field, kind, given_values, value, keep):
        if given_values:
            array = ffi.new(f"{kind}[]", len(given_values))
            for to, (name, one) in zip(array, given_values.items()):
                keep.extend((ffi.new("char[]", encoded(name, field)),
                             ffi.new("char[]", encoded(str(one), field))))
                to.name = keep[-2]
                setattr(to, value, keep[-1])
            keep.append(array)
            setattr(define, count, len(given_values))
            setattr(define, field, array)

    def _read(self, f) -> None:
        def records(count, items):
            return [plain(ffi.addressof(items[k])) for k in range(count)]

        self.name = text(f.name)
        self.bodies = [text(f.body_name[k]) for k in range(f.bodies)]
        self.joints = records(f.joints, f.joint)
        for one in self.joints:
            one.kind = _KINDS[one.kind]
        self.sites = records(f.sites, f.site)
        self.actuators = records(f.actuators, f.actuator)
        self.sensors = records(f.sensors, f.sensor)
        self.shapes = records(f.shapes, f.shape)
        self.findings = records(f.findings, f.finding)
        self.keys = [text(f.key[k].name) for k in range(f.keys)]
        self.q0 = view(self._handle, f.q0, (f.nq,))
        self.control = view(self._handle, f.control, (f.actuators,), write=True)

    def key(self, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q (nq), u (nu) and the control (actuators) of a named state; KeyError: there is none."""
        f = self._get()
        at = lib.mbsr_file_find_key(f, name.encode())
        if at < 0:
            raise KeyError(name)
        one = f.key[at]
        return (view(self._handle, one.q, (f.nq,)), view(self._handle, one.u, (f.nu,)),
                view(self._handle, one.control, (f.actuators,)))

    def sense(self, name: str, data: Data, q: np.ndarray, u: np.ndarray,
              t: float = 0.0) -> np.ndarray:
        """The numbers of a sensor at a state at which the data are (Data.accelerations for
        forces)."""
        f = self._get()
        at = lib.mbsr_file_find_sensor(f, name.encode())
        if at < 0:
            raise KeyError(name)
        out = np.empty(4)
        status = lib.mbsr_file_sense(f, at, self.model._get(), data._get(), t,
                                     given(q, (f.nq,), "q"), given(u, (f.nu,), "u"),
                                     taken(out, (4,), "out"))
        if status:
            fail(status, lib.mbsr_data_error(data._get()))
        return out[:f.sensor[at].size]

    def from_mujoco(self, qpos: np.ndarray, qvel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q and u of MuJoCo's qpos (nq) and qvel (nu)."""
        return self._convert(0, qpos, qvel, "qpos", "qvel")

    def to_mujoco(self, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The other way."""
        return self._convert(1, q, u, "q", "u")

    def _convert(self, inverse, first, second, *names):
        f = self._get()
        outs = np.empty(f.nq), np.empty(f.nu)
        status = lib.mbsr_file_mujoco_state(
            f, inverse, given(first, (f.nq,), names[0]), given(second, (f.nu,), names[1]),
            taken(outs[0], (f.nq,), "q"), taken(outs[1], (f.nu,), "u"))
        if status:
            fail(status)
        return outs

    def __repr__(self):
        if self.closed:
            return "<File, closed>"
        return (f"<File '{self.name}': {len(self.bodies)} bodies, {len(self.joints)} joints, "
                f"{len(self.actuators)} actuators, {len(self.findings)} findings>")


def read(source: str | os.PathLike, **options) -> File:
    """Reads a file of URDF, xacro, MJCF or SDF.

    options: folders (where files that it names may be, beside its own folder and ../meshes),
    packages (name: folder), arguments (of xacro), and the fields of mbsr_file_opt: strict,
    floating, gravity, closures, actuators, passive, limits, friction and others."""
    return File(source, **options)


def to_mjcf(model: Model, file: File | None = None) -> tuple[str, list[Record]]:
    """A model as a text of MJCF, and findings: what MJCF cannot say. `file`: what it was read
    from, for names, sites, actuators, keys and shapes."""
    model.finish()
    made = _create("mbsr_written", lib.mbsr_file_write_mjcf, model._get(),
                   ffi.NULL if file is None else file._get(), ffi.NULL)
    written = ffi.gc(made, lib.mbsr_written_destroy)
    return (ffi.string(written.text).decode(),
            [plain(ffi.addressof(written.finding[k])) for k in range(written.findings)])

# SPDX-License-Identifier: BSD-3-Clause
"""Models, and what is evaluated at a state of them.

Shapes: q (nq) joint position coordinates, u (nu) joint rates, udot their derivatives, tau joint
forces conjugate to u. Arrays are C-contiguous float64 of exactly these shapes; others are refused
by name. What a method returns is a new array, or the one given as `out`."""
from __future__ import annotations

from typing import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _values
from ._c import ffi, lib
from ._core import (F8, Handle, Owner, Record, encoded, evaluated, fail, given, given_ints,
                    numbers, plain, taken, text)
from ._values import Closure, Force, FrameLike, Inertia, Joint
from .flexible import Flex

GROUND = lib.MBSR_GROUND
NONE = lib.MBSR_NONE
_NULL, _forward, _inverse = ffi.NULL, lib.mbsr_forward_dynamics, lib.mbsr_inverse_dynamics


def _create(what: str, function, *arguments):
    """Calls a function that makes an object and tells why it does not."""
    error, made = ffi.new("mbsr_error *"), ffi.new(f"{what} **")
    status = function(*arguments, made, error)
    if status:
        fail(status, error)
    return made[0]


class Model(Owner):
    """A multibody system: a tree of bodies with joints, inertias, force elements and closures of
    loops.

    It is built by calls and finished: by `finish`, or by what is made of it first (data, a batch,
    a run). Then it can be read, does not change any more, and any number of data, solvers and runs
    may use it. rank_tolerance: what counts as zero mass, relative (default 1e-12)."""

    def __init__(self, rank_tolerance: float | None = None):
        define = _values._box("mbsr_model_def", lib.mbsr_default_model_def())
        if rank_tolerance is not None:
            define.rank_tolerance = rank_tolerance
        made = _create("mbsr_model", lib.mbsr_model_create, ffi.addressof(define))
        self._start(Handle(made, lib.mbsr_model_destroy))

    def _start(self, handle: Handle) -> "Model":
        self._handle = handle
        self._finished = False
        self._sizes: tuple = ()
        return self

    @classmethod
    def _of(cls, pointer, *keep) -> "Model":
        """One that the library has made."""
        return cls.__new__(cls)._start(Handle(pointer, lib.mbsr_model_destroy, *keep))

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_model_error(self._get()))

    def _hold(self, keep) -> None:
        self._get()
        for one in keep:
            self._handle.hold(one)  # type: ignore[union-attr]

    # ---- building ----

    def add_body(self, name: str | None, joint: Joint, inertia: Inertia | None = None,
                 parent: int = GROUND) -> int:
        """Adds a body that hangs by a joint on its predecessor (an id, default the ground), and
        returns its id. Without an inertia its mass is zero, and zero is honoured."""
        define = _values._box("mbsr_body_def", lib.mbsr_default_body_def())
        keep: list = []
        define.name = _values.to_c("const char *", "name", name, keep)
        define.parent = parent
        define.joint = _values.to_c("mbsr_joint", "joint", joint, keep)
        if inertia is not None:
            define.inertia = _values.to_c("mbsr_inertia", "inertia", inertia, keep)
        made = ffi.new("int *")
        self._check(lib.mbsr_model_add_body(self._get(), ffi.addressof(define), made))
        self._hold(keep)
        return made[0]

    def add_force(self, force: Force, name: str | None = None) -> int:
        """Adds a force element and returns its id."""
        return self._add(force, Force, lib.mbsr_model_add_force, name)

    def add_closure(self, closure: Closure, name: str | None = None) -> int:
        """Adds a closure of a loop and returns its id."""
        return self._add(closure, Closure, lib.mbsr_model_add_closure, name)

    def _add(self, value, kind, function, name):
        if not isinstance(value, kind):
            raise TypeError(f"expected {kind.__name__}, got {type(value).__name__}")
        if name is not None:
            value.name = name
        made = ffi.new("int *")
        self._check(function(self._get(), value._box, made))
        self._hold(value._keep)
        return made[0]

    def add_flexible(self, name: str | None, flex: Flex, parent: int = GROUND, marker: int = 0,
                     joint: Joint | None = None) -> int:
        """Adds a flexible body, held at a marker of its data to a predecessor, by a joint or fast,
        and returns its id. With a joint a body without mass stands between, its id one less."""
        define = _values._box("mbsr_flexible_def", lib.mbsr_default_flexible_def())
        keep: list = [flex._handle]
        define.name = _values.to_c("const char *", "name", name, keep)
        define.parent, define.flex, define.marker = parent, flex._get(), marker
        if joint is not None:
            define.joint = _values.to_c("mbsr_joint", "joint", joint, keep)
        made = ffi.new("int *")
        self._check(lib.mbsr_model_add_flexible(self._get(), ffi.addressof(define), made))
        self._hold(keep)
        return made[0]

    def add_marker(self, name: str | None, body: int, marker: int) -> int:
        """Adds a body without mass that moves with a marker of a flexible one; returns its id."""
        made, keep = ffi.new("int *"), []
        self._check(lib.mbsr_model_add_marker(
            self._get(), body, marker, _values.to_c("const char *", "name", name, keep), made))
        return made[0]

    def add_loop_joint(self, name: str | None, body: int, joint: Joint, other: int,
                       frame_other: FrameLike = None) -> tuple[int, int]:
        """Closes a loop by a joint of any kind between two bodies; returns the closure and the cut
        body, whose coordinates are those of the joint."""
        keep: list = []
        made = ffi.new("int[2]")
        self._check(lib.mbsr_model_add_loop_joint(
            self._get(), _values.to_c("const char *", "name", name, keep), body, joint._box, other,
            _values.to_c("const mbsr_frame *", "frame_other", frame_other, keep), made, made + 1))
        self._hold(joint._keep)
        return made[0], made[1]

    def lock(self, body: int, coordinate: int, value: float) -> None:
        """Holds a joint coordinate at a value: it is no coordinate of the model any more."""
        self._check(lib.mbsr_model_lock(self._get(), body, coordinate, value))

    def armature(self, body: int, values: ArrayLike) -> None:
        """Inertia of motors behind gears, added to the joint's rates (n): kg m^2 or kg."""
        array = numbers(values, None, "values")
        self._check(lib.mbsr_model_armature(self._get(), body, array.size,
                                            ffi.from_buffer("double[]", array)))

    def regularise(self, body: int, matrix: ArrayLike) -> None:
        """Adds a mass matrix (d x d) to that of a body."""
        array = np.ascontiguousarray(matrix, dtype=F8)
        self._check(lib.mbsr_model_regularise(self._get(), body, len(array),
                                              ffi.from_buffer("double[]", array)))

    def neglect(self, body: int, mass: bool = True, moment: bool = True) -> None:
        """Counts a body's mass, its moments about its centre of mass, or both as zero."""
        parts = lib.MBSR_MASS * mass + lib.MBSR_MOMENT * moment
        self._check(lib.mbsr_model_neglect(self._get(), body, parts))

    def restore(self, body: int) -> None:
        """Takes back what was neglected."""
        self._check(lib.mbsr_model_restore(self._get(), body))

    def copy(self) -> "Model":
        """A model that is not finished, with the same parts, to be changed."""
        made = _create("mbsr_model", lib.mbsr_model_copy, self._get())
        return Model._of(made, self._handle)

    def finish(self) -> "Model":
        """Checks and numbers all of it; after this it does not change. Called again it does
        nothing."""
        pointer = self._get()
        if not self._finished:
            self._check(lib.mbsr_model_finish(pointer))
            self._is_finished()
        return self

    def _is_finished(self) -> "Model":
        """Of one that the library has finished."""
        pointer = self._get()
        self._finished = True
        self._sizes = (lib.mbsr_model_nq(pointer), lib.mbsr_model_nu(pointer))
        return self

    # ---- reading, once it is finished ----

    def _read(self):
        pointer = self._get()
        if not self._finished:
            fail(lib.MBSR_ERR_UNFINISHED)
        return pointer

    def _body(self, body: int):
        pointer = self._read()
        if not 0 <= body < lib.mbsr_model_bodies(pointer):
            raise IndexError(f"there is no body {body}")
        return pointer

    def _numbers(self) -> tuple:
        self._read()
        return self._sizes

    @property
    def nq(self) -> int:
        """Joint position coordinates in all."""
        return self._numbers()[0]

    @property
    def nu(self) -> int:
        """Joint rates in all: the degrees of freedom of the tree."""
        return self._numbers()[1]

    @property
    def bodies(self) -> int:
        """How many bodies there are; their ids count from 0."""
        return lib.mbsr_model_bodies(self._read())

    @property
    def forces(self) -> int:
        """How many force elements there are."""
        return lib.mbsr_model_forces(self._read())

    @property
    def closures(self) -> int:
        """How many closures there are."""
        return lib.mbsr_model_closures(self._read())

    @property
    def rows(self) -> int:
        """Velocity rows of all closures."""
        return lib.mbsr_model_rows(self._read())

    def body_name(self, body: int) -> str:
        """Its name, "" without."""
        return text(lib.mbsr_body_name(self._body(body), body))

    @property
    def body_names(self) -> list[str]:
        """The names by id."""
        return [self.body_name(k) for k in range(self.bodies)]

    def find_body(self, name: str) -> int:
        """The id of the body of that name; KeyError: there is none."""
        found = lib.mbsr_model_find_body(self._read(), encoded(name, "name"))
        if found < 0:
            raise KeyError(name)
        return found

    def parent(self, body: int) -> int:
        """The predecessor of a body: an id, or GROUND."""
        return lib.mbsr_body_parent(self._body(body), body)

    def coordinates(self, body: int) -> tuple[slice, slice]:
        """Where the coordinates of its joint stand in q, and its rates in u."""
        four = ffi.new("int[4]")
        status = lib.mbsr_body_coordinates(self._read(), body, four, four + 1, four + 2,
                                           four + 3)
        if status:
            fail(status)
        return slice(four[0], four[0] + four[1]), slice(four[2], four[2] + four[3])

    def coordinate_names(self) -> tuple[list[str], list[str]]:
        """Names of the numbers in q and in u: of the body, with a number where its joint has
        several."""
        names: tuple[list[str], list[str]] = ([], [])
        for body in range(self.bodies):
            name = self.body_name(body) or f"body {body}"
            for to, place in zip(names, self.coordinates(body)):
                count = place.stop - place.start
                to.extend([name] if count == 1 else [f"{name}[{k}]" for k in range(count)])
        return names

    def start(self) -> np.ndarray:
        """q (nq) with all coordinates zero and quaternions 1."""
        q = np.zeros(self.nq)
        for body in range(self.bodies):
            at, rates = self.coordinates(body)
            if at.stop - at.start == rates.stop - rates.start + 1:
                q[at.start] = 1.0
        return q

    def __repr__(self):
        if self.closed:
            return "<Model, closed>"
        if not self._finished:
            return "<Model, not finished>"
        return (f"<Model: {self.bodies} bodies, {self.forces} force elements, {self.closures} "
                f"closures, nq {self.nq}, nu {self.nu}>")

    # ---- what is made of it ----

    def data(self) -> "Data":
        """Memory for evaluations; one for each thread."""
        return Data(self)

    def batch(self, threads: int = 1) -> "Batch":
        """Memory for evaluations of many states at once."""
        return Batch(self, threads)

    def index_report(self, q: np.ndarray, u: np.ndarray, t: float = 0.0) -> "IndexReport":
        """Which joint directions move no mass at a state, what determines them, and the
        differential index."""
        return IndexReport(self, q, u, t)


class Data(Owner):
    """The state of evaluations of a model."""

    def __init__(self, model: Model):
        model.finish()
        made = _create("mbsr_data", lib.mbsr_data_create, model._get())
        self._handle = Handle(made, lib.mbsr_data_destroy, model._handle)
        self.model = model
        self._model = model._get()
        self._nq, self._nu = (model.nq,), (model.nu,)
        self._seen: list = [None] * 8

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_data_error(self._get()))

    # ---- dynamics ----

    def forward_dynamics(self, q: np.ndarray, u: np.ndarray, tau: np.ndarray | None = None,
                         t: float = 0.0, out: np.ndarray | None = None) -> np.ndarray:
        """udot (nu) of the motion at (t, q, u) under joint forces tau (nu, None: none) and all
        force elements."""
        nu = self._nu
        if out is None:
            out = np.empty(nu)
        status = _forward(self._model, (self._handle or self._get()).pointer, t,
                          *evaluated(self._seen, q, self._nq, u, nu, tau, nu, out, "q u tau"))
        if status:
            self._check(status)
        return out

    def inverse_dynamics(self, q: np.ndarray, u: np.ndarray, udot: np.ndarray, t: float = 0.0,
                         out: np.ndarray | None = None,
                         motors: Sequence[int] | None = None) -> np.ndarray:
        """tau (nu) that makes the motion (q, u, udot). motors: numbers of the joint rates that are
        driven, the others are not, and closures carry the rest (None: all are driven, and closures
        exert nothing)."""
        nu = self._nu
        if out is None:
            out = np.empty(nu)
        if udot is None:
            given(udot, nu, "udot")
        at_q, at_u, at_udot, to = evaluated(self._seen, q, self._nq, u, nu, udot, nu, out,
                                              "q u udot")
        driven = _NULL
        if motors is not None:
            rates = ffi.new("int[]", list(motors))
            driven = ffi.new("mbsr_motors *", {"count": len(motors), "rate": rates})
        status = _inverse(self._model, (self._handle or self._get()).pointer, t, at_q, at_u,
                          at_udot, driven, to)
        if status:
            self._check(status)
        return out

    def bias_forces(self, q: np.ndarray, u: np.ndarray, t: float = 0.0,
                    out: np.ndarray | None = None) -> np.ndarray:
        """tau (nu) at udot = 0: with the mass matrix M the equations of motion are M udot + bias =
        tau."""
        if out is None:
            out = np.empty(self._nu)
        self._check(lib.mbsr_bias_forces(self._model, self._get(), t, given(q, self._nq, "q"),
                                         given(u, self._nu, "u"), taken(out, self._nu, "out")))
        return out

    def mass_matrix(self, q: np.ndarray, t: float = 0.0,
                    out: np.ndarray | None = None) -> np.ndarray:
        """The joint-space mass matrix (nu x nu), symmetric; it may be singular."""
        shape = self._nu * 2
        if out is None:
            out = np.empty(shape)
        self.positions(q, t)
        self._check(lib.mbsr_mass_matrix(self._model, self._get(), taken(out, shape, "out")))
        return out

    # ---- stages ----

    def positions(self, q: np.ndarray, t: float = 0.0) -> "Data":
        """Evaluates poses at q (nq)."""
        self._check(lib.mbsr_stage_positions(self._model, self._get(), t, given(q, self._nq, "q")))
        return self

    def velocities(self, q: np.ndarray, u: np.ndarray, t: float = 0.0) -> "Data":
        """Evaluates poses and twists at q (nq) and u (nu)."""
        self.positions(q, t)
        self._check(lib.mbsr_stage_velocities(self._model, self._get(), given(u, self._nu, "u")))
        return self

    def accelerations(self, q: np.ndarray, u: np.ndarray, udot: np.ndarray,
                      tau: np.ndarray | None = None, t: float = 0.0) -> "Data":
        """Evaluates all that a motion under joint forces tau (nu, None: none) has: accelerations
        of bodies, reactions of joints."""
        self.velocities(q, u, t)
        self._check(lib.mbsr_stage_forces(self._model, self._get(),
                                    _NULL if tau is None else given(tau, self._nu, "tau")))
        self._check(lib.mbsr_stage_accelerations(self._model, self._get(),
                                                 given(udot, self._nu, "udot")))
        return self

    def coordinate_rates(self, q: np.ndarray, u: np.ndarray, t: float = 0.0) -> np.ndarray:
        """q' (nq), which differs from u where joints have quaternions."""
        self.velocities(q, u, t)
        out = np.empty(self._nq)
        self._check(lib.mbsr_coordinate_rates(self._model, self._get(),
                                              taken(out, self._nq, "out")))
        return out

    # ---- results at the state evaluated ----

    def _numbers(self, function, body: int, count: int) -> np.ndarray:
        out = np.empty(count)
        self._check(function(self._model, self._get(), body, taken(out, (count,), "out")))
        return out

    def _dimension(self, body: int) -> int:
        count = lib.mbsr_body_dimension(self._model, body)
        if count < 0:
            raise IndexError(f"there is no body {body}")
        return count

    def pose(self, body: int) -> np.ndarray:
        """The pose of a body. In space 12 numbers, R by columns and the origin (see frame)."""
        self._dimension(body)
        return self._numbers(lib.mbsr_body_pose, body, lib.mbsr_body_pose_size(self._model, body))

    def frame(self, body: int) -> _values.Frame:
        """The pose of a body in space as a frame in the world."""
        pose = self.pose(body)
        if pose.size < lib.MBSR_POSE_SIZE:
            raise ValueError(f"body {body} is not a body in space")
        return _values.Frame(pose[9:12], pose[:9].reshape(3, 3).T)

    def twist(self, body: int) -> np.ndarray:
        """Its velocity (d): in space angular velocity, then that of its origin, along the world's
        axes."""
        return self._numbers(lib.mbsr_body_twist, body, self._dimension(body))

    def acceleration(self, body: int) -> np.ndarray:
        """Its acceleration (d), after `accelerations`."""
        return self._numbers(lib.mbsr_body_acceleration, body, self._dimension(body))

    def reaction(self, body: int) -> np.ndarray:
        """What its joint exerts on it (d): in space the moment about its origin (N m) and the
        force (N)."""
        return self._numbers(lib.mbsr_joint_reaction, body, self._dimension(body))

    def jacobian(self, body: int) -> np.ndarray:
        """J (d x nu) with twist = J u + what moves by itself."""
        shape = (self._nu[0], self._dimension(body))
        out = np.empty(shape)
        self._check(lib.mbsr_body_jacobian(self._model, self._get(), body,
                                           taken(out, shape, "out")))
        return out.T

    def point(self, body: int, at: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity (3 each, m, m/s) of a point of a body given along its axes."""
        out = np.empty((2, 3))
        place = numbers(at, 3, "at")
        self._check(lib.mbsr_body_point(
            self._model, self._get(), body, ffi.from_buffer("double[]", place),
            ffi.from_buffer("double[]", out[0]), ffi.from_buffer("double[]", out[1]), ffi.NULL))
        return out[0], out[1]

    def energy(self) -> tuple[float, float]:
        """Kinetic and potential energy, J."""
        out = ffi.new("double[2]")
        self._check(lib.mbsr_energy(self._model, self._get(), out, out + 1))
        return out[0], out[1]

    def dissipation(self) -> float:
        """Power that force elements turn into heat, W."""
        out = ffi.new("double *")
        self._check(lib.mbsr_dissipation(self._model, self._get(), out))
        return out[0]

    def momentum(self, about: ArrayLike = (0.0, 0.0, 0.0)) -> tuple[float, np.ndarray, np.ndarray]:
        """Mass, centre of mass (3), and momentum (6: angular about a point, linear) of the whole
        tree."""
        mass, centre, six = ffi.new("double *"), np.empty(3), np.empty(6)
        place = numbers(about, 3, "about")
        self._check(lib.mbsr_tree_momentum(
            self._model, self._get(), ffi.from_buffer("double[]", place), mass,
            ffi.from_buffer("double[]", centre), ffi.from_buffer("double[]", six)))
        return mass[0], centre, six

    def rank(self, body: int) -> Record:
        """What the rank decision at its joint was (mbsr_rank_info)."""
        out = ffi.new("mbsr_rank_info *")
        self._check(lib.mbsr_body_rank(self._model, self._get(), body, out))
        return plain(out)

    # ---- loops ----

    def assemble(self, q: np.ndarray, t: float = 0.0) -> tuple[np.ndarray, Record]:
        """Positions near q (nq) in which all loops close, and what was found on the way."""
        out, info = np.empty(self._nq), ffi.new("mbsr_assembly_info *")
        self._check(lib.mbsr_assemble(self._model, self._get(), t, given(q, self._nq, "q"),
                                      _NULL, taken(out, self._nq, "out"), info))
        return out, plain(info)

    def gaps(self, q: np.ndarray, t: float = 0.0) -> np.ndarray:
        """What the loops are open by at q, one number a position row."""
        out = np.empty(lib.mbsr_model_position_rows(self._model))
        self.positions(q, t)
        self._check(lib.mbsr_closures_gap(self._model, self._get(),
                                          taken(out, out.shape, "out")))
        return out


class Batch(Owner):
    """One model at many states in a call. The interpreter's lock is released, so that threads go
    on; `threads` > 1 shares a call out among as many of the library's own. States are rows: q
    (states, nq), u (states, nu)."""

    def __init__(self, model: Model, threads: int = 1):
        model.finish()
        keep = [model._handle]
        if threads != 1:
            crew = _create("mbsr_threads", lib.mbsr_threads_create, threads)
            keep.append(Handle(crew, lib.mbsr_threads_destroy))
            parallel = ffi.new("mbsr_parallel *", lib.mbsr_threads_parallel(crew))
            keep.append(parallel)
            made = _create("mbsr_batch", lib.mbsr_batch_create_parallel, model._get(), parallel)
        else:
            made = _create("mbsr_batch", lib.mbsr_batch_create, model._get())
        self._handle = Handle(made, lib.mbsr_batch_destroy, *keep)
        self.model = model
        self._model = model._get()

    @property
    def lanes(self) -> int:
        """States that go side by side; multiples of it are cheapest."""
        return lib.mbsr_batch_lanes(self._get())

    def _run(self, function, q, u, third, name, t, out, status):
        nq, nu = self.model.nq, self.model.nu
        states = len(q) if isinstance(q, np.ndarray) and q.ndim == 2 else 0
        shape = (states, nu)
        arguments = [given(q, (states, nq), "q"), given(u, shape, "u"),
                     ffi.NULL if third is None and name == "tau" else given(third, shape, name)]
        if out is None:
            out = np.empty(shape)
        codes = ffi.NULL if status is None else ffi.from_buffer("int[]", status, True)
        if status is not None:
            given_ints(status, (states,), "status")
        result = function(self._model, self._get(), t, states, *arguments,
                          taken(out, shape, "out"), codes)
        if result and (status is None or result < 0):
            fail(result, lib.mbsr_batch_error(self._get()))
        return out

    def forward_dynamics(self, q: np.ndarray, u: np.ndarray, tau: np.ndarray | None = None,
                         t: float = 0.0, out: np.ndarray | None = None,
                         status: np.ndarray | None = None) -> np.ndarray:
        """udot (states, nu). status (states, int32), where it is given, receives what becomes of
        each state, and states that fail (NaN there) do not raise."""
        return self._run(lib.mbsr_batch_forward_dynamics, q, u, tau, "tau", t, out, status)

    def inverse_dynamics(self, q: np.ndarray, u: np.ndarray, udot: np.ndarray, t: float = 0.0,
                         out: np.ndarray | None = None,
                         status: np.ndarray | None = None) -> np.ndarray:
        """tau (states, nu), likewise."""
        return self._run(lib.mbsr_batch_inverse_dynamics, q, u, udot, "udot", t, out, status)


class Direction:
    """A combination of joint rates that moves no mass: kind ("damped", "elastic", "undetermined"),
    terms (body, coordinate, weight) and the force elements and closures that determine it."""

    _KINDS = {lib.MBSR_DIRECTION_DAMPED: "damped", lib.MBSR_DIRECTION_ELASTIC: "elastic",
              lib.MBSR_DIRECTION_UNDETERMINED: "undetermined"}

    def __init__(self, d, names: Sequence[str]):
        self.kind = self._KINDS[int(d.kind)]
        self.terms = [(d.term[k].body, d.term[k].coordinate, d.term[k].weight)
                      for k in range(d.terms)]
        self.forces = [d.force[k] for k in range(d.forces)]
        self.closures = [d.closure[k] for k in range(d.closures)]
        self._names = names

    def __repr__(self):
        sums = " + ".join(f"{weight:g} {self._names[body]}[{coordinate}]"
                          for body, coordinate, weight in self.terms)
        by = ", ".join([*(f"force {k}" for k in self.forces),
                        *(f"closure {k}" for k in self.closures)])
        return f"{self.kind}: {sums}" + (f" (by {by})" if by else "")


class IndexReport:
    """Which joint directions move no mass, and what determines them. index: differential index of
    the equations of motion (0, 1, 2; -1 with undetermined directions); dynamic, damped, elastic,
    undetermined, loop_supported: how many there are of each kind; directions: those without mass;
    conditioning; text: what to do about undetermined ones."""

    def __init__(self, model: Model, q: np.ndarray, u: np.ndarray, t: float = 0.0):
        data = model.data()
        made = ffi.new("mbsr_index_report **")
        data._check(lib.mbsr_index_report_create(
            model._get(), data._get(), t, given(q, (model.nq,), "q"), given(u, (model.nu,), "u"),
            made))
        report = ffi.gc(made[0], lambda one: lib.mbsr_index_report_destroy(data._model, one))
        names = [name or f"body {k}" for k, name in enumerate(model.body_names)]
        self.__dict__.update(plain(report, skip=("directions",))._fields())
        self.directions = [Direction(report.direction[k], names) for k in range(report.directions)]

    def __iter__(self) -> Iterator[Direction]:
        return iter(self.directions)

    def __len__(self):
        return len(self.directions)

    def __str__(self):
        head = (f"index {self.index}: {self.dynamic} dynamic, {self.damped} damped, {self.elastic} "
                f"elastic, {self.undetermined} undetermined directions")
        return "\n".join([head, *(f"  {one!r}" for one in self.directions),
                          *filter(None, [self.text])])

    __repr__ = __str__

    def _repr_html_(self):
        rows = "".join(f"<tr><td>{one.kind}</td><td>{one!r}</td></tr>" for one in self.directions)
        return (f"<p>index {self.index}: {self.dynamic} dynamic, {self.damped} damped, "
                f"{self.elastic} elastic, {self.undetermined} undetermined</p>"
                f"<table>{rows}</table>")

# SPDX-License-Identifier: BSD-3-Clause
"""Runs: a model integrated from a consistent start, as an iterator of states; and tables of
them."""
from __future__ import annotations

from typing import Any, Callable, Iterable, Iterator

import numpy as np

from . import _values
from ._c import ffi, lib
from ._core import Handle, Owner, Record, fail, given, plain
from .dae import Dae
from .model import Model, _create


class State:
    """A state of a run: t (s), q (nq), u (nu), udot (nu), forces of loops (rows); event: the
    directions in which event functions have changed their sign (+1, -1, 0), None where the state
    is no event."""

    __slots__ = ("t", "q", "u", "udot", "loop_forces", "event")

    def __init__(self, t, q, u, udot, loop_forces, event=None):
        self.t, self.q, self.u, self.udot = t, q, u, udot
        self.loop_forces, self.event = loop_forces, event

    def __repr__(self):
        return f"State(t={self.t!r}, q={self.q!r}, u={self.u!r})"


class Simulation(Owner):
    """A run of a model by IDA, from a consistent state near q (nq; None: all coordinates zero) and
    u (nu; None: at rest) at time t.

    events: a function (t, y, yp) -> numbers, `event_count` of them, at whose changes of sign the
    run stops; progress: a function of a record (t, steps, step, order) between steps, which stops
    the run by returning True; options: fields of mbsr_ida_opt, such as rtol and atol. What these
    functions raise reaches the caller of the run.

    Iterating over `states(times)` gives State objects; `sim.data` is at the last state, so that
    poses, reactions and energies can be asked for."""

    def __init__(self, model: Model, q: np.ndarray | None = None, u: np.ndarray | None = None,
                 t: float = 0.0, form: str = "momentum",
                 events: Callable[[float, np.ndarray, np.ndarray], Any] | None = None,
                 event_count: int = 1, progress: Callable[[Record], Any] | None = None,
                 start: dict | None = None, **options):
        self._dae = Dae(model, form)
        self.model, self.data = model, self._dae.data
        self._events = event_count if events is not None else 0
        keep: list = []
        define = _values.options("mbsr_ida_opt", options, keep, "Simulation")
        define.form = self._dae.form
        if events is not None:
            handle = ffi.new_handle((self._dae.size, event_count, events))
            keep.append(handle)
            define.events, define.event_user = event_count, handle
            define.event = lib.mbsrank_mbsr_event_fn
        if progress is not None:
            define.progress, define.progress_user = _values.callback("mbsr_ida_progress_fn",
                                                                     progress, keep)
        made = _create("mbsr_ida", lib.mbsr_ida_create, model._get(), self.data._get(),
                       define)
        self._handle = Handle(made, lib.mbsr_ida_destroy, self.data._handle)
        for one in keep:
            self._handle.hold(one)
        self._t = ffi.new("double *")
        self._four = [np.empty(n) for n in (model.nq, model.nu, model.nu, model.rows)]
        self.restart(q, u, t, **(start or {}))

    def _check(self, status: int) -> None:
        if status:
            fail(status, lib.mbsr_ida_error(self._get()))

    def restart(self, q: np.ndarray | None = None, u: np.ndarray | None = None, t: float = 0.0,
                **options) -> "Simulation":
        """Begins again from another state; options: fields of mbsr_consistent_opt."""
        q = self.model.start() if q is None else q
        u = np.zeros(self.model.nu) if u is None else u
        y, yp, self.start = self._dae.consistent(q, u, t, **options)
        shape = (self._dae.size,)
        self._check(lib.mbsr_ida_start(self._get(), t, given(y, shape, "y"),
                                       given(yp, shape, "yp")))
        self._read()
        return self

    def _read(self) -> None:
        pointers = [ffi.from_buffer("double[]", one, True) if one.size else ffi.NULL
                    for one in self._four]
        self._check(lib.mbsr_ida_motion(self._get(), *pointers))
        self._check(lib.mbsr_ida_state(self._get(), self._t, ffi.NULL, ffi.NULL))

    # ---- the present state ----

    @property
    def t(self) -> float:
        """Time, s."""
        self._get()
        return self._t[0]

    def _view(self, k: int) -> np.ndarray:
        self._get()
        seen = self._four[k].view()
        seen.flags.writeable = False
        return seen

    @property
    def q(self) -> np.ndarray:
        """Joint position coordinates (nq): a view that follows the run, as u, udot and
        loop_forces."""
        return self._view(0)

    @property
    def u(self) -> np.ndarray:
        """Joint rates (nu)."""
        return self._view(1)

    @property
    def udot(self) -> np.ndarray:
        """Their derivatives (nu)."""
        return self._view(2)

    @property
    def loop_forces(self) -> np.ndarray:
        """Forces of closures (rows)."""
        return self._view(3)

    def state(self, event=None) -> State:
        """A copy of the present state."""
        self._get()
        q, u, udot, loop_forces = (one.copy() for one in self._four)
        return State(self._t[0], q, u, udot, loop_forces, event)

    # ---- going on ----

    def to(self, t: float) -> State:
        """Integrates to time t, or to the first event before it."""
        return self._go(lib.mbsr_ida_advance, t)

    def sample(self, t: float) -> State:
        """The same over one sampling period, in which forces that the caller holds are constant:
        steps end at t."""
        return self._go(lib.mbsr_ida_sample, t)

    def _go(self, function, t: float) -> State:
        status = function(self._get(), t, ffi.NULL, ffi.NULL, ffi.NULL)
        event = None
        if status == lib.MBSR_EVENT:
            directions = ffi.new("int[]", self._events)
            self._check(lib.mbsr_ida_event_info(self._get(), directions))
            event = list(directions)
        elif status:
            fail(status, lib.mbsr_ida_error(self._get()))
        self._read()
        return self.state(event)

    def states(self, times: Iterable[float]) -> Iterator[State]:
        """The states at these times, and those of events between them."""
        for t in times:
            while True:
                state = self.to(float(t))
                yield state
                if state.event is None:
                    break

    def run(self, times: Iterable[float]) -> "Run":
        """All these states as a table."""
        return Run(self.model, list(self.states(times)))

    # ---- what it cost ----

    @property
    def stats(self) -> Record:
        """What has been integrated since the start has cost."""
        out = ffi.new("mbsr_ida_stats *")
        self._check(lib.mbsr_ida_get_stats(self._get(), out))
        return plain(out)

    @property
    def drift(self) -> Record:
        """How far the present state is from what should hold: gaps of loops, change of energy."""
        out = ffi.new("mbsr_ida_drift *")
        self._check(lib.mbsr_ida_get_drift(self._get(), out))
        return plain(out)


class Run:
    """States of a run, one a row: t (n), q (n, nq), u (n, nu), udot (n, nu), loop_forces (n,
    rows)."""

    def __init__(self, model: Model, states: list[State]):
        self.states = states
        self.t = np.array([one.t for one in states])
        self.q = np.array([one.q for one in states]).reshape(len(states), model.nq)
        self.u = np.array([one.u for one in states]).reshape(len(states), model.nu)
        self.udot = np.array([one.udot for one in states]).reshape(len(states), model.nu)
        forces = np.array([one.loop_forces for one in states])
        self.loop_forces = forces.reshape(len(states), model.rows)
        self._names = model.coordinate_names()

    def __len__(self):
        return len(self.states)

    def __iter__(self) -> Iterator[State]:
        return iter(self.states)

    def __getitem__(self, k) -> State:
        return self.states[k]

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Columns by name: t, q of each coordinate, u of each rate."""
        found = {"t": self.t}
        for letter, names, values in zip("qu", self._names, (self.q, self.u)):
            found.update({f"{letter} {name}": values[:, k] for k, name in enumerate(names)})
        return found

    def to_pandas(self) -> Any:
        """A DataFrame with time as its index; needs pandas."""
        import pandas  # type: ignore[import]

        return pandas.DataFrame(self.columns).set_index("t")

    def __repr__(self):
        if not self.states:
            return "<Run, empty>"
        return f"<Run: {len(self)} states, t {self.t[0]:g} .. {self.t[-1]:g} s>"

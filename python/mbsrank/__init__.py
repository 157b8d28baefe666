# SPDX-License-Identifier: BSD-3-Clause
"""O(N) dynamics of multibody systems whose bodies may have zero or rank-deficient mass.

Models are built by calls (Model, with the modules joint, inertia, force, closure) or read from
files (read), and evaluated by Data, Batch, Derivatives, Dae, Newton, Ode; Simulation and Stepper
integrate them. All of C is in `lib` and `ffi`."""
from . import closure, force, inertia, joint
from ._c import ffi, lib
from ._core import ClosedError, Error, ForceBody, Record, StateError, UseError
from ._values import Closure, Force, Frame, Inertia, Joint, Table
from .dae import Dae, Newton, Ode
from .derivatives import Derivatives
from .driver import Run, Simulation, State
from .files import File, read, to_mjcf
from .model import GROUND, NONE, Batch, Data, IndexReport, Model
from .small_masses import SmallMasses
from .stepper import Stepper
from .viewer import Page, view

__version__ = ffi.string(lib.mbsr_version()).decode()

__all__ = [
    "Batch", "ClosedError", "Closure", "Dae", "Data", "Derivatives", "Error", "File", "Force",
    "ForceBody", "Frame", "GROUND", "IndexReport", "Inertia", "Joint", "Model", "NONE", "Newton",
    "Ode",
    "Page", "Record",
    "Run", "Simulation", "SmallMasses", "State", "StateError", "Stepper",
    "Table", "UseError", "closure", "ffi", "force",
    "inertia", "joint", "lib", "read", "to_mjcf", "view",
]

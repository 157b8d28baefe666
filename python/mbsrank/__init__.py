# SPDX-License-Identifier: BSD-3-Clause
"""O(N) dynamics of multibody systems whose bodies may have zero or rank-deficient mass.

Models are built by calls (Model, with the modules joint, inertia, force, closure) or read from
files (read), and evaluated by Data, Batch, Derivatives, Dae, Newton, Ode; Simulation and Stepper
integrate them. Parameters are values by name; linear has equilibria, linear equations and modes;
Contacts are shapes that touch, Flex bodies that bend; Sensitivity has derivatives of runs in
parameters; export_fmu makes Functional Mock-up Units. All of C is in `lib` and `ffi`."""
from . import casadi, closure, force, inertia, joint, linear
from ._c import ffi, lib
from ._core import ClosedError, Error, ForceBody, Record, StateError, UseError
from ._values import Closure, Force, Frame, Inertia, Joint, Table
from .contacts import Contacts, touching
from .dae import Dae, Newton, Ode
from .derivatives import Derivatives
from .driver import Run, Simulation, State
from .flexible import Flex
from .fmu import export_fmu
from .files import File, read, to_mjcf
from .model import GROUND, NONE, Batch, Data, IndexReport, Model
from .parameters import Parameters
from .sensitivity import Sensitivity
from .small_masses import SmallMasses
from .stepper import Stepper
from .viewer import Page, view

__version__ = ffi.string(lib.mbsr_version()).decode()

__all__ = [
    "Batch", "ClosedError", "Closure", "Contacts", "Dae", "Data", "Derivatives", "Error",
    "File", "Flex", "Force", "ForceBody", "Frame", "GROUND", "IndexReport", "Inertia", "Joint",
    "Model", "NONE", "Newton", "Ode", "Page", "Parameters", "Record", "Run", "Sensitivity",
    "Simulation", "SmallMasses", "State", "StateError", "Stepper", "Table", "UseError",
    "casadi", "closure", "export_fmu", "ffi", "force", "inertia", "joint", "lib", "linear",
    "read", "to_mjcf", "touching", "view",
]

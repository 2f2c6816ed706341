"""The dielectric elastomer actuator: a spring network with charged electrodes on it.

At a voltage V the network and its charges have the potential

    Π(x) = U(x) - f·x - W(x, V),    W = ½ΣQV,

U the springs' energy and W the electrodes', charges free to follow. Rest is where it is stationary,
stability where its second derivative K_mech - K_elec is positive, and pull-in where that ends.
`device` says what an actuator is; `films` makes slabs, and `models` say what charges do to it.
`balance` and `equilibria` find its rest, `motion` moves it there, `modes` tell how near pull-in it
is, and `uniform` has closed forms.
"""

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.equilibria import (
    ActuatorEquilibrium,
    PulledIn,
    at_voltage,
    sweep,
)
from msvalidate.dielectric.actuator.films import fix_near_tips, slab
from msvalidate.dielectric.actuator.modes import lowest_modes
from msvalidate.dielectric.actuator.motion import relax_actuator

__all__ = [
    "Actuator",
    "ActuatorEquilibrium",
    "PulledIn",
    "at_voltage",
    "fix_near_tips",
    "lowest_modes",
    "relax_actuator",
    "slab",
    "sweep",
]

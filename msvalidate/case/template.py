"""The commented case file that `case new` writes."""

from __future__ import annotations

TEMPLATE = """\
# A case: a body under loads, for springs and for elements. Run it with
#   msvalidate case run {file}
schema = 1
name = "{name}"

[body]
# One of box, polygon and mesh; mesh is a .msh, .vtu, .vtk or .inp file beside this one.
box = [4.0, 1.0]
# polygon = [[0, 0], [4, 0], [4, 2], [0, 1]]   # counter-clockwise
# mesh = "part.msh"
unit = "m"                # of all lengths in this file and its mesh: m, cm, mm, um, in ...

[material]
E = 1e5                   # Pa
nu = 0.3333333333333333
state = "plane_stress"    # or "plane_strain"; leave it out in space
thickness = 1.0           # in the unit of length; leave it out in space
# density = 1000.0        # kg/m3, for gravity
# law = "neo-hookean"     # of elements at large strain; st-venant-kirchhoff if left out

# [[region]]              # a part of another material
# box = {{ x = [2.0, 4.0] }} # or cells = "name in the mesh"
# E = 1e6
# nu = 0.3

[[support]]               # as many as are needed to hold the body
on = "left"               # a side: left, right, bottom, top, back, front, or a name in the mesh
# at = {{ x = 0.0, y = [0.0, 1.0] }}   # or a place: numbers, intervals; what is left out is free
# nodes = [0, 17]         # or nodes of the mesh, numbered from 0 as the file lists them
# components = ["x", "y"] # those held; all if left out
# value = [0.0, 0.0]      # their displacements, in the unit of length

[[load]]
on = "right"
traction = [0.0, -10.0]   # Pa; or pressure = 10.0 (positive inwards)
# [[load]]
# force = [0.0, -1.0]     # N, with point = [4.0, 0.5] or node = 3
# [[load]]
# gravity = [0.0, -9.81]  # m/s2

# [[contact]]             # a rigid obstacle that may touch and not be entered
# on = "top"
# disc = {{ at = [2.0, 1.0], radius = 2.0 }} # its foremost point; or half_space, ball, parabola
# depth = 0.01            # lowered by; or force = 1.0 in N

# [fracture]              # springs that break as loads are raised together
# critical_stretch = 0.01 # elongation over length; or G_c = 10.0 in J/m2, by rule "growth"
# raised = 2.0            # times the loads

[springs]
# on = "mesh"             # of the body's own mesh: linear elements, whose springs are under tension
# lattice = "square"      # square in the plane, cubic18 in space; or "mesh edges"
cells = 20                # across the narrowest side; or spacing = 0.05
# route = "volume energy" # from material to springs; springs alone where they will do

[compare]
points = "lattice"        # or "mesh", or [[1.0, 0.5], [4.0, 0.5]]
band = 0.05               # largest difference that agrees, over the largest displacement
# geometry = "nonlinear"  # springs and elements at rest however large the displacement
# memory = 4.0            # GB that the elements' finest mesh in space may take
# quantities = ["displacement", "reactions", "strain energy", "mean stress", "point stress"]

[reference]
accuracy = 1e-3           # of elasticity, over the largest displacement
"""


def template(file: str, name: str) -> str:
    """Text of a case file that runs as it is."""
    return TEMPLATE.format(file=file, name=name)

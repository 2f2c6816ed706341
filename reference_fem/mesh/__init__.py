"""Bodies as meshes: elements and their maps, boxes, polygons and given meshes, points, matrices.

`make_discretisation` takes a mesh as arrays; the others make one of a domain. All return a
`Discretisation`.
"""

from reference_fem.mesh.boxes import box_discretisation, lines_discretisation
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS, Element
from reference_fem.mesh.facets import Facets
from reference_fem.mesh.from_mesh import mesh_discretisation
from reference_fem.mesh.triangles import polygon_discretisation

__all__ = [
    "ELEMENTS",
    "Discretisation",
    "Element",
    "Facets",
    "box_discretisation",
    "lines_discretisation",
    "make_discretisation",
    "mesh_discretisation",
    "polygon_discretisation",
]

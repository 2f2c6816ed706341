"""A network's tangent and its inverse: factor or multigrid, mechanisms, and signs of energy."""

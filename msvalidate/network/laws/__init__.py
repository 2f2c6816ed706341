"""What acts between points beside springs: energies of cells, and springs that resist shear."""

"""What acts between points beside springs: energies of cells."""

"""Springs of a case: their answers on finer lattices and on the part's own mesh."""

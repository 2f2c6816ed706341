"""Reports of cases: pages, figures, files and sweeps over values."""

"""From a case file to a `Case`: keys, units, places and the part's own mesh."""

"""Springs of a case compared with elements: quantities, budget and range of validity."""

"""Linear models of a scenario, for python-control: ``systems`` makes them."""

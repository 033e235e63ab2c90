"""Replays of a fleet: the program `tertius`, once for each recording, in the order of each machine.

`step` does one recording, `engine` all of them on Dask, `report` makes one page from the tables of all machines.
"""

"""Putative and selected matches as files: NPZ, HDF5 of hloc, CSV and COLMAP databases (docs/matches.md)."""

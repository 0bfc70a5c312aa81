"""Selecting the correct ones among putative feature matches: see corrsel.matches and corrsel.msg."""

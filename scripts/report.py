#!/usr/bin/env python3
"""Starts the report of a run from rosrun: the same as python3 -m corrsel.report."""
import sys

from corrsel.report.__main__ import main

sys.exit(main())

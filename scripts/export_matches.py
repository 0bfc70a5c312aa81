#!/usr/bin/env python3
"""Starts the export of saved matches from rosrun: the same as python3 -m corrsel.files."""
import sys

from corrsel.files.__main__ import main

sys.exit(main())

#!/usr/bin/env bash
# Usage: compare.sh BEFORE AFTER. Exit code: 0 if no mean F moved by more than the tolerance (README.md explains how
# it was chosen), 1 if one did or values are missing, 2 if a folder is damaged.
set -euo pipefail

# The columns from the dataset to the number of inliers describe the input of the selectors.
given() { cut -d, -f1-12 "$1/pairs.csv"; }

if cmp -s <(given "$1") <(given "$2"); then
  echo "the same matches in every row: strict tolerance"
  tolerance=0.002
else
  echo "other matches (other features, or other rows): wide tolerance"
  tolerance=0.03
fi
exec rosrun corrsel compare_runs --strict --tolerance "$tolerance" "$1" "$2"

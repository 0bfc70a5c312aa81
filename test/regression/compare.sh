#!/usr/bin/env bash
# compare.sh BEFORE AFTER: exit code 0 where no mean F moved by more than the tolerance (README.md says how it was
# chosen), 1 where one did or values are missing, 2 where a folder is damaged.
set -euo pipefail

# Dataset to number of ground-truth inliers: what the selectors were given.
given() { cut -d, -f1-11 "$1/pairs.csv"; }

if cmp -s <(given "$1") <(given "$2"); then
  echo "the same matches in every row: strict tolerance"
  tolerance=0.002
else
  echo "other matches (other features, or other rows): wide tolerance"
  tolerance=0.03
fi
exec rosrun corrsel compare_runs --strict --tolerance "$tolerance" "$1" "$2"

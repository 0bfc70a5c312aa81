#!/usr/bin/env bash
# Usage: run.sh OUTPUT_DIR [SELECTORS]. Repeats the run whose results are stored in expected/, on the built-in sample
# set with SIFT. Without SELECTORS it takes the stored ones, so that a new selector does not change the comparison.
set -euo pipefail
expected=$(dirname "$0")/expected
selectors=${2:-$(sed -n 's/^selectors: \[\(.*\)\]$/\1/p' "$expected/config.yaml" | tr -d ' ')}
exec rosrun corrsel benchmark --dataset sample --features sift+sift --preselection none --selectors "$selectors" \
  --tolerances 5 --threads 2 --seed 0 --report false --output_dir "$1"

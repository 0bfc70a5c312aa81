#!/usr/bin/env bash
# Usage: run.sh OUTPUT_DIR [SELECTORS]. Repeats the run whose results are stored in expected/: the same selectors, or the
# given ones, on the built-in sample set with SIFT.
set -euo pipefail
expected=$(dirname "${BASH_SOURCE[0]}")/expected/config.yaml
selectors=${2:-$(sed -n 's/^selectors: \[\(.*\)\]$/\1/p' "$expected" | tr -d ' ')}
exec rosrun corrsel benchmark --dataset sample --features sift+sift --preselection none --selectors "$selectors" \
  --tolerances 5 --threads 2 --seed 0 --report false --output_dir "$1"

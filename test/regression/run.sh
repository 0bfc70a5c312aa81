#!/usr/bin/env bash
# run.sh OUTPUT_DIR: the run whose results are kept in expected/: SIFT on the built-in sample set, all selectors.
set -euo pipefail
exec rosrun corrsel benchmark --dataset sample --features sift+sift --preselection none --selectors all \
  --tolerances 5 --threads 2 --seed 0 --report false --output_dir "$1"

#!/usr/bin/env bash
# Usage: run.sh OUTPUT_DIR. Repeats the run whose results are stored in expected/: all selectors on the built-in
# sample set with SIFT.
set -euo pipefail
exec rosrun corrsel benchmark --dataset sample --features sift+sift --preselection none --selectors all \
  --tolerances 5 --threads 2 --seed 0 --report false --output_dir "$1"

#!/usr/bin/env bash
# Fits the weights of Selection::probability to the matches of datasets with ground truth, writes them to
# src/posterior/probability_weights.cpp, and their calibration to docs/data/probability.csv. Prints for each dataset and for all
# together a table by probability, and the average log loss beside the lowest one that a threshold on the probability reaches; at
# last the same where the weights come from the other sources of images alone. Run it after changes to `auto` or to the local
# support, and then scripts/generate.py. It takes two minutes.
#   scripts/maintenance/train_probability.sh --data_root FOLDER
# FOLDER holds vgg, symbench, strecha_dev and adelaidermf, and what scripts/maintenance/kitti_pairs.py makes of the frames of KITTI.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

case ${1:--h} in -h | --help) sed -n '2,9s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;; esac
install_packages "${build_packages[@]}"
build train_probability -- -DCMAKE_BUILD_TYPE=Release
say "training"
weights=$(mktemp)
trap 'rm -f "$weights"' EXIT
"$build_dir/devel/lib/corrsel/train_probability" --csv "$package_dir/docs/data/probability.csv" "$@" >"$weights"
cat "$weights" >"$package_dir/src/posterior/probability_weights.cpp"
say "wrote src/posterior/probability_weights.cpp and docs/data/probability.csv"

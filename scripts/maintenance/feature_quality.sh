#!/usr/bin/env bash
# Installs what is needed, builds (Release), and compares the quality of features: repeatability, right putative matches,
# and F of selections, on the pairs of datasets with homographies. Prints tables in Markdown. Arguments are those of the
# program; the most important ones:
#   --data_root FOLDER   folder that holds the folders of the datasets (needed)
#   --dataset NAMES      vgg,symbench by default
#   --features LIST      sift+sift=cv_sift+cv_sift compares the first with the second; hessian_affine+sift measures only
#   --max_features N     second measurement with this limit, 2000 by default
#   --options LIST       options of the algorithms, e.g. sift.contrast_threshold=0.03
# Exit code 0 only if no mean is more than 0.5 points below that of the features that it is compared with.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

for argument in "$@"; do
  case $argument in -h | --help) sed -n '2,11s/^# //p' "${BASH_SOURCE[0]}" && exit 0 ;; esac
done
install_packages "${build_packages[@]}"
build feature_quality -- -DCMAKE_BUILD_TYPE=Release
say "measuring"
"$build_dir/devel/lib/corrsel/feature_quality" "$@"

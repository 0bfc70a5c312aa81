#!/usr/bin/env bash
# Runs every check of a release on one commit, and prints a table of their results; --help explains it.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
install_packages python3 python3-yaml git
exec python3 "$package_dir/scripts/maintenance/release_check.py" "$@"

set -euo pipefail
cd /tmp/w/platform/main
set -- 
source /tmp/w/platform/main/scripts/common.sh
source scripts/root_file_system.sh
r=/tmp/roots/platforms/$SUITE
install_in $r ca-certificates ccache iproute2 $EXTRA "${build_packages[@]}" "${test_packages[@]}" "${performance_packages[@]}"
echo done

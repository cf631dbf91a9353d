#!/bin/sh
# Checks the exposure level of the service by systemd-analyze security: at most 1.9. Skipped (77) if systemd is
# not installed.
set -eu
units=${1:?folder of the units}
command -v systemd-analyze >/dev/null || exit 77
report=$(systemd-analyze security --offline=true --threshold=19 --no-pager "$units/infused.service") ||
  { echo "$report"; exit 1; }
echo "$report" | tail -n 1

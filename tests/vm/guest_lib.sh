# Shared functions of the guest scripts. Sourced.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
failures=0
pass() { echo "ok      $*"; }
miss() { echo "NOT OK  $*"; failures=$((failures + 1)); }
# check NAME COMMAND...: reports whether the command succeeds.
check() {
  local name=$1; shift
  if "$@" >/tmp/check.log 2>&1; then pass "$name"; else miss "$name"; tail -n 12 /tmp/check.log; return 1; fi
}
# within SECONDS COMMAND...: retries until the command succeeds; the timeout is multiplied by `timeout_factor`.
timeout_factor=1
steady_s() { awk '{print $1}' /proc/uptime; }
within() {
  local deadline=$((SECONDS + timeout_factor * $1)); shift
  until "$@" >/dev/null 2>&1; do ((SECONDS < deadline)) || return 1; sleep 0.2; done
}
finish() { echo "$failures failures"; exit $((failures > 0)); }
# well DEVICE...: each delivers data: level OK or WARN, and a rate above 0. A slow emulated processor loses
# packets and images, which the daemon reports (WARN); this is not tested here.
well() {
  local report device
  report=$(infuse status 2>/dev/null)
  for device; do grep -qE "^  (OK|WARN) +$device: [0-9.]*[1-9]" <<<"$report" || return 1; done
}
all_ok() {
  if ((timeout_factor > 1)); then infuse wait-ready --timeout 2; else well top front bus; fi
}
alert() { journalctl -u infused -o cat 2>/dev/null | grep -q "$1"; }
# moment WHAT: timestamp of the service by systemd, ms of the monotonic clock.
moment() { echo $(($(systemctl show -P "$1TimestampMonotonic" infused) / 1000)); }
# kill_daemon: kills the daemon and queries the next one. Sets `killed` and `answered`, ms of the monotonic clock,
# and `stalled`, ms for which the host did not run the virtual machine meanwhile.
kill_daemon() {
  read -r killed answered stalled < <(/proof/vm-clients kill "$(systemctl show -P MainPID infused)" \
    /run/infuse/infused.sock /run/vm/waited)
}

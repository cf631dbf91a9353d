#!/bin/bash
# In the guest: the installed package, live sensors, watchdog; with "faults" also what can go wrong. /proof
# holds the package, a capture to send, and the programs that send and wedge.
. /proof/guest_lib.sh
# The quick part is run on busy hosts too: there the figures are only told.
[[ ${1-} == faults ]] || patience=10
export DEBIAN_FRONTEND=noninteractive

# The host's manuals are none of this test's business, and indexing them takes minutes here.
rm -f /var/lib/man-db/auto-update
# A host that is a container itself may forbid packages to start services.
rm -f /usr/sbin/policy-rc.d
check "package installs" dpkg -i /proof/infuse.deb
check "the service is enabled" systemctl is-enabled infused.service infused.socket
check "without sensors it runs" within 20 systemctl is-active infused.service
check "user, state and socket are there" sh -c 'id infuse && test -d /var/lib/infuse && test -S /run/infuse/infused.sock'
check "net.core.rmem_max was raised" sh -c 'test "$(sysctl -n net.core.rmem_max)" = 16777216'

cat >/etc/infuse/infused.toml.d/test.toml <<'TOML'
[[lidar]]
name = "top"
model = "VLP-16"
[[camera]]
name = "front"
device = "/dev/video0"
width = 320
height = 240
format = "GREY"
[[can]]
name = "bus"
interface = "vcan0"
TOML
check "the configuration is right" infused --check-config --config /etc/infuse/infused.toml

# The senders read their files before the clock is watched: a file of the host is slow the first time.
(while /proof/infuse-send-capture /proof/street.pcap; do :; done) >/tmp/sender.log 2>&1 & sender=$!
canplayer -l i -I /proof/can.log vcan0=vcan0 >/tmp/canplayer.log 2>&1 & player=$!
sleep 1
started=$(date +%s%N)
systemctl restart infused.service
check "all three deliver within $((5 * patience)) s of start" infuse wait-ready --timeout $((5 * patience))
echo "        after $((($(date +%s%N) - started) / 1000000)) ms"
check "and are OK" within 5 all_ok
infuse status
systemctl status infused --no-pager -n 0 | sed -n 's/^ *Status/        status/p'
check "it runs without root" sh -c 'test "$(ps -o user= -p "$(systemctl show -P MainPID infused)")" = infuse'
check "it has no capability" sh -c 'grep -q "^CapEff:\s*0*$" /proc/$(systemctl show -P MainPID infused)/status'
check "the io thread has real-time priority" sh -c 'chrt -p $(ps -L -o tid=,comm= -p $(systemctl show -P MainPID infused) | awk "\$2 == \"io\" {print \$1}") | grep -q FIFO'
check "security: at most 1.9" systemd-analyze security --threshold=19 --no-pager infused.service
check "a reload keeps the process" sh -c 'p=$(systemctl show -P MainPID infused); systemctl reload infused && sleep 1 && test "$p" = "$(systemctl show -P MainPID infused)"'
check "and the sensors" within 3 all_ok

# Things that go wrong, and the same process goes on.
if [[ ${1-} == faults ]]; then . /proof/faults.sh; fi

# --- restarts ---
kill -9 "$(systemctl show -P MainPID infused)"; at=$(date +%s%N)
check "SIGKILL: back within $((3 * patience)) s" within 3 sh -c "systemctl is-active infused && infuse status --json | grep -q DEVICES"
echo "        after $((($(date +%s%N) - at) / 1000000)) ms"
check "and says so" within 5 alert "did not end by itself"
check "and all are OK" within 6 all_ok
if [[ ${1-} == faults ]]; then
back() { systemctl is-active infused && infuse status --json | grep -q DEVICES; }
# Half of them while a recording is written, which must be a drive afterwards.
kills=50 slowest=0 broken=0
for round in $(seq $kills); do
  ((round % 2)) || infuse record --no-wait -o "kill$round" >/dev/null 2>&1
  sleep "0.$((RANDOM % 10))"
  at=$(date +%s%N)
  kill -9 "$(systemctl show -P MainPID infused)"
  within 3 back || { miss "SIGKILL $round: not back within 3 s"; within 10 back; }
  took=$((($(date +%s%N) - at) / 1000000)); ((took <= slowest)) || slowest=$took
  grep -q '"running": true' /var/lib/infuse/state.json || miss "SIGKILL $round: the state is damaged"
  ((round % 2)) || infuse inspect "/var/lib/infuse/drives/kill$round" >/tmp/inspect.log 2>&1 ||
    { broken=$((broken + 1)); tail -n 3 /tmp/inspect.log; }
done
pass "$kills kills at random moments, back after $slowest ms at most"
check "no recording was damaged by them" test "$broken" = 0
check "and all are OK" within 8 all_ok
. /proof/record.sh

mount -t tmpfs -o size=16k,uid=infuse,gid=infuse,mode=750 none /var/lib/infuse
systemctl restart infused.service
head -c 16k /dev/zero >/var/lib/infuse/fill 2>/dev/null
check "disk full: it says so, and goes on" within 25 sh -c 'journalctl -u infused -o cat | grep -q "No space left" && systemctl is-active infused'
systemctl stop infused.service; umount /var/lib/infuse; systemctl start infused.service
within 10 back
as() { setpriv --reuid=65534 --regid="$1" --clear-groups "${@:2}"; }
check "another user cannot ask" sh -c '! setpriv --reuid=65534 --regid=65534 --clear-groups infuse status'
for attempt in "cat /var/lib/infuse/state.json" "ls /var/lib/infuse/drives" "touch /etc/infuse/infused.toml.d/x.toml" \
  "rm /run/infuse/infused.sock" "kill -HUP $(systemctl show -P MainPID infused)" \
  "cat /proc/$(systemctl show -P MainPID infused)/environ"; do
  check "nor: ${attempt%% /*}" sh -c "! setpriv --reuid=65534 --regid=65534 --clear-groups $attempt"
done
check "the group infuse can ask" sh -c 'setpriv --reuid=65534 --regid=infuse --clear-groups infuse status --json | grep -q DEVICES'
if as infuse /proof/vm-clients refused /run/infuse/infused.sock; then pass "but change nothing"; else miss "but change nothing"; fi
check "nothing listens on a network but the lidar's ports" sh -c '! ss -Hltn | grep -q . && ss -Hlun | awk "{print \$4}" | grep -qx "0.0.0.0:2368"'
check "all are OK" within 8 all_ok
fi
tid=$(ps -L -o tid=,comm= -p "$(systemctl show -P MainPID infused)" | awk '$2 == "fusion" {print $1}')
before=$(systemctl show -P NRestarts infused)
/proof/vm-wedge "$tid" 20 & wedge=$!
check "fusion thread wedged: the watchdog restarts it" within 15 sh -c "test \$(systemctl show -P NRestarts infused) -gt $before"
kill $wedge 2>/dev/null
check "and all are OK" within 8 all_ok
at=$(date +%s%N)
check "a clean stop" systemctl stop infused.service
took=$((($(date +%s%N) - at) / 1000000))
check "within $((2 * patience)) s ($took ms)" test $took -lt $((2000 * patience))
check "its state says that it ended by itself" grep -q '"running": false' /var/lib/infuse/state.json

# --- package ---
check "a client starts it through the socket" within 5 sh -c 'infuse status --json | grep -q DEVICES && systemctl is-active infused'
check "upgrade keeps it running" sh -c 'dpkg -i /proof/infuse.deb && systemctl is-active infused'
check "remove stops it" sh -c 'dpkg -r infuse && ! systemctl is-active infused && ! test -e /usr/bin/infused'
check "and keeps the configuration" test -e /etc/infuse/infused.toml
check "purge leaves nothing" sh -c 'dpkg -P infuse && ! test -e /var/lib/infuse && ! test -e /etc/infuse/infused.toml && ! test -e /run/infuse'
kill $sender $player 2>/dev/null
((failures == 0)) || journalctl -u infused -o short-monotonic --no-pager | tail -n 60
finish

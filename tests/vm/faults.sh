# In the guest: faults that the daemon must survive, beside a client that never reads. Sourced by service.sh.
# vcan has no controller that could go bus-off: its error frames are sent by cansend instead.
pid=$(systemctl show -P MainPID infused)
resident() { awk '/^VmRSS/ {print $2}' "/proc/$pid/status"; }
descriptors() { ls "/proc/$pid/fd" | wc -l; }
sleep 20  # until every slot of every ring has been used once
resident_before=$(resident) descriptors_before=$(descriptors)
/proof/vm-clients never-read /run/infuse/infused.sock 600 & holder=$!

ip link set lidar0 down
check "lidar interface down: ERROR or STALE" within 8 sh -c 'infuse status | grep -qE "(ERROR|STALE) +top"'
ip link set lidar0 up
check "up again: it delivers, without a restart" within 8 well top

ip link set vcan0 down
check "CAN interface down: unavailable" within 5 sh -c 'infuse status | grep -q "interface is down"'
ip link set vcan0 up
hush_bus; play_bus
check "up again: it delivers, without a restart" within 8 well bus
for _ in 1 2 3; do cansend vcan0 20000040#0000000000000000; sleep 0.05; done
hush_bus
cansend vcan0 20000040#0000000000000000
check "CAN bus-off is reported" within 5 sh -c 'infuse status | grep -q bus-off'
play_bus
check "and cleared" within 8 well bus

vivid=$(basename "$(readlink -f /sys/class/video4linux/video0/device)")
echo "$vivid" >/sys/bus/platform/drivers/vivid/unbind
check "camera unbound: unavailable" within 5 sh -c 'infuse status | grep -qE "(ERROR|STALE) +front"'
sleep 4  # the retry delay has reached its maximum
echo "$vivid" >/sys/bus/platform/drivers/vivid/bind
check "bound: it delivers, without a restart" within 10 well front
# logged PATTERN: time of the last journal line that matches.
logged() { journalctl -b -o short-monotonic | sed -n "s/^\[ *\([0-9.]*\)\].*$1\$/\1/p" | tail -n 1; }
awk -v a="$(logged 'registered as video0')" -v b="$(logged 'video0: opened')" \
  'BEGIN {printf "        opened %.0f ms after the kernel registered it\n", 1000 * (b - a)}'

date -s '+1 hour' >/dev/null; sleep 2; date -s '-2 hours' >/dev/null; sleep 2; date -s '+1 hour' >/dev/null
# canplayer is paced by the wall clock, too.
hush_bus; play_bus
check "the wall clock stepped by 1 h both ways: all OK" within 5 all_ok

check "a thousand connections at once" /proof/vm-clients connect-many /run/infuse/infused.sock 1000
check "the daemon still answers" within 3 sh -c 'infuse status --json | grep -q DEVICES'

kill $holder 2>/dev/null
sleep 1
check "the same process survived all of it" sh -c "test $pid = \$(systemctl show -P MainPID infused)"
resident_after=$(resident) descriptors_after=$(descriptors)
check "memory flat: $resident_before kB, then $resident_after kB" test "$resident_after" -lt $((resident_before + 16384))
check "descriptors flat: $descriptors_before, then $descriptors_after" test "$descriptors_after" -le $((descriptors_before + 2))

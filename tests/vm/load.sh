# In the guest: overload by all sensors at once. The missing data must be exactly the reported losses. Sourced
# by service.sh. The reference: the sender's count, the kernel's counters of sockets and bus, and the cameras'
# running time.
cat >/etc/infuse/infused.toml.d/test.toml <<'TOML'
[[lidar]]
name = "top"
model = "VLS-128"
address = "10.77.0.2"
receive_buffer_bytes = 400000
[[camera]]
name = "front"
device = "/dev/video0"
width = 320
height = 240
format = "GREY"
[[camera]]
name = "rear"
device = "/dev/video1"
width = 320
height = 240
format = "GREY"
[[can]]
name = "bus"
interface = "vcan0"
[metrics]
port = 9469
[odometry]
use_lidar = false  # on an emulated processor a registration takes seconds
TOML
metrics() {
  exec 5<>/dev/tcp/127.0.0.1/9469 || return 1
  printf 'GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n' >&5
  tr -d '\r' <&5 >/tmp/metrics
  exec 5>&-
  grep -q infuse_ /tmp/metrics
}
# figure NAME LABELS: value of one metric in the last scrape.
figure() { awk -v name="$1{$2}" '$1 == name {printf "%d", $2}' /tmp/metrics; }
# stream NAME DEVICE KIND
stream() { figure "infuse_stream_$1_total" "device=\"$2\",kind=\"$3\""; }
# Drops at the ports of data packets and of position packets: 10.77.0.2, 2368 and 8308.
socket_drops() { awk '$2 == "02004D0A:0940" || $2 == "02004D0A:2074" {n += $NF} END {print n}' /proc/net/udp; }
on_the_bus() { cat /sys/class/net/vcan0/statistics/rx_packets; }
hush
systemctl stop infused.service
for camera in 0 1; do v4l2-ctl -d /dev/video$camera --set-dv-bt-timings index=5 >/dev/null; done  # 30 Hz
systemctl start infused.service
check "two cameras deliver" within 10 sh -c 'infuse status | grep -E "(OK|WARN) +rear" && infuse status | grep -E "(OK|WARN) +front"'
sleep 3
check "the metrics are served" within 10 metrics
time_before=$(steady_s)
bus_received=$(stream received bus can) bus_lost=$(stream lost bus can)
front=$(($(stream received front camera) + $(stream lost front camera)))
rear=$(($(stream received rear camera) + $(stream lost rear camera)))
bus_before=$(on_the_bus)
cangen vcan0 -g 0 -n 40000 -I i -L 8 -D i & cans=$!
ip netns exec car /proof/infuse-send-capture /proof/dual.pcap --to 10.77.0.2 --rate 3 >/tmp/sent & lidar=$!
# Stop the daemon for a second.
sleep 1
daemon=$(systemctl show -P MainPID infused)
kill -STOP "$daemon"; sleep 1; kill -CONT "$daemon"
wait $cans $lidar
# The kernel reports drops with the next datagram or frame.
sleep 2
ip netns exec car /proof/infuse-send-capture /proof/tail.pcap --to 10.77.0.2 >/tmp/sent_after
for _ in 1 2 3; do cansend vcan0 123#00; sleep 0.1; done
sleep 3
check "the metrics are served after it" within 10 metrics || journalctl -u infused -o short-monotonic --no-pager | tail -n 25
seconds=$(awk -v a="$time_before" -v b="$(steady_s)" 'BEGIN {print b - a}')
packets=$(figure infuse_lidar_packets_total 'device="top"')
positions=$(figure infuse_lidar_position_packets_total 'device="top"')
kernel=$(figure infuse_lidar_packets_lost_total 'device="top",cause="kernel"')
network=$(figure infuse_lidar_packets_lost_total 'device="top",cause="network"')
sent=$(($(cut -d' ' -f1 /tmp/sent) + $(cut -d' ' -f1 /tmp/sent_after)))
echo "        lidar: $sent datagrams sent, $((packets + positions)) received, lost: $kernel in the kernel, $network in the network"
check "lidar: every missing item is reported" test $((packets + positions + kernel + network)) = "$sent"
check "and what the kernel counts at the sockets ($(socket_drops))" test "$kernel" = "$(socket_drops)"
check "the load was more than it could take" test "$kernel" -gt 0
sent=$(($(on_the_bus) - bus_before))
received=$(($(stream received bus can) - bus_received)) lost=$(($(stream lost bus can) - bus_lost))
echo "        bus: $sent frames sent, $received received, $lost lost"
check "bus: every missing item is reported" test $((received + lost)) = $sent
for name in front rear; do
  images=$(($(stream received $name camera) + $(stream lost $name camera) - ${!name}))
  echo "        $name: $images images received or lost ($(stream lost $name camera)) in $seconds s"
  # HEALTH is up to a second old, at both ends.
  check "$name: as many as 30 Hz make" awk -v n="$images" -v s="$seconds" 'BEGIN {exit !(n > 30 * s - 45 && n < 30 * s + 45)}'
done
use_three_sensors
send_lidar
play_bus
systemctl restart infused.service

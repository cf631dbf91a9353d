# In the guest: what other users must not be able to do. Sourced by service.sh.
outside() { setpriv --reuid=65534 --regid=65534 --clear-groups "$@"; }
inside() { setpriv --reuid=65534 --regid=infuse --clear-groups "$@"; }
daemon=$(systemctl show -P MainPID infused)
check "another user cannot connect" sh -c '! setpriv --reuid=65534 --regid=65534 --clear-groups infuse status'
# A table: each must fail.
while IFS= read -r attempt; do
  if outside sh -c "$attempt" >/dev/null 2>&1 </dev/null; then miss "another user: $attempt"; else pass "another user cannot: $attempt"; fi
done <<ATTEMPTS
cat /var/lib/infuse/state.json
ls /var/lib/infuse/drives
touch /var/lib/infuse/x
touch /etc/infuse/infused.toml.d/x.toml
echo >>/etc/infuse/infused.toml
rm /run/infuse/infused.sock
mv /run/infuse/infused.sock /run/infuse/other
touch /run/infuse/x
kill -HUP $daemon
kill -KILL $daemon
cat /proc/$daemon/environ
cat /proc/$daemon/mem
ls /proc/$daemon/fd
/proof/vm-wedge $daemon 1
chrt -f -p 1 $daemon
systemctl --no-ask-password restart infused
systemctl --no-ask-password stop infused.socket
infuse record --no-wait -o other
infuse recalibrate front
infuse wait-ready --timeout 1
ATTEMPTS
if outside /proof/vm-clients refused /run/infuse/infused.sock >/tmp/outside.log; then pass "another user: $(sed -n '$s/^ *//p' /tmp/outside.log)"; else miss "another user"; cat /tmp/outside.log; fi
check "the group infuse can query" sh -c 'setpriv --reuid=65534 --regid=infuse --clear-groups infuse status --json | grep -q DEVICES'
if inside /proof/vm-clients refused /run/infuse/infused.sock; then pass "but not control"; else miss "but not control"; fi
check "by the same process" test "$daemon" = "$(systemctl show -P MainPID infused)"
check "no network port is open except the lidar's" sh -c '! ss -Hltn | grep -q . && ss -Hlun | awk "{print \$4}" | grep -qx "0.0.0.0:2368"'
check "all are OK" within 8 all_ok

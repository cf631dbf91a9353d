# In the guest: kills the daemon at random moments, half of them during a recording, which must be a valid drive
# afterwards. Sourced by service.sh. One program kills and waits for the answer, because starting programs is
# slow on an emulated processor.
kills=50 damaged=0
: >/tmp/kills
back() { systemctl is-active infused && infuse status --json | grep -q DEVICES; }
files() { find /var/lib/infuse -maxdepth 1 -type f | wc -l; }
temporaries() { find /tmp /var/tmp -maxdepth 1 -name 'systemd-private-*-infused*' | wc -l; }
files_before=$(files) temporaries_before=$(temporaries)
for round in $(seq $kills); do
  ((round % 2)) || infuse record --no-wait -o "kill$round" >/dev/null 2>&1
  sleep "0.$((RANDOM % 10))"
  kill_daemon
  within 10 systemctl is-active infused || miss "SIGKILL $round: the service is not active"
  forked=$(moment ExecMainStart) ready=$(moment ActiveEnter)
  took=$(((ready > answered ? ready : answered) - killed))
  echo "$took $stalled $((forked - killed)) $((ready - forked))" >>/tmp/kills
  # A late restart: print the journal.
  ((took <= 3000)) || journalctl --no-pager -o short-monotonic -n 60 | sed 's/^/        /'
  grep -q '"running": true' /var/lib/infuse/state.json || miss "SIGKILL $round: the state is damaged"
  ((round % 2)) || infuse inspect "/var/lib/infuse/drives/kill$round" >/tmp/inspect.log 2>&1 ||
    { damaged=$((damaged + 1)); tail -n 3 /tmp/inspect.log; }
done
# Time for which the host stalled the machine is reported and subtracted.
slow=$(awk '$1 - $2 > 3000' /tmp/kills | wc -l)
check "$(wc -l </tmp/kills) kills at random moments: $slow of them not back within 3 s" test "$slow" = 0 -a "$(wc -l </tmp/kills)" = $kills
middle() { sort -n -k "$1" /tmp/kills | awk -v k="$1" -v at=$((kills / 2)) 'NR == at {m = $k} END {print m " ms (median), " $k " ms (longest)"}'; }
echo "        back after $(middle 1); of that, until the next process started $(middle 3), from then until it was active $(middle 4)"
echo "        the machine was stalled for $(middle 2); with it $(awk '$1 > 3000' /tmp/kills | wc -l) took more than 3 s"
check "no recording was damaged by them" test $damaged = 0
check "nothing is left behind: files $files_before, then $(files); folders $temporaries_before, then $(temporaries)" \
  test "$(files)" -le $((files_before + 1)) -a "$(temporaries)" -le "$temporaries_before"
check "and all are OK" within 8 all_ok
rm -rf /var/lib/infuse/drives/kill*

// The page's history against a list that keeps everything.
//   node tests/view/history_test.js
import assert from 'node:assert';
import fs from 'node:fs';
import vm from 'node:vm';

const file = new URL('../../daemon/view/page/history.js', import.meta.url);
const DriveHistory = vm.runInThisContext(fs.readFileSync(file, 'utf8') + ';DriveHistory');
const latest = (all, key, t) => all.filter(e => e.key === key && e.t <= t).reduce((a, b) => !a || b.t >= a.t ? b : a, null);

{ // Within the bounds everything is found again, at every time.
  const history = new DriveHistory(), all = [];
  for (let k = 0; k < 500; ++k) {
    const entry = {key: k % 3 ? 'sweep:top' : 'HEALTH', t: 1000 + k * 0.1 - (k % 7 === 0 ? 0.25 : 0), value: k};
    all.push(entry);
    history.add(entry.key, entry.t, entry.value, 100);
  }
  for (let t = 1000; t < 1052; t += 0.037) {
    const found = new Map(history.at(t));
    for (const key of ['sweep:top', 'HEALTH']) assert.strictEqual(found.get(key), latest(all, key, t)?.value ?? null);
    const times = all.filter(e => e.key === 'sweep:top').map(e => e.t);
    const after = times.filter(x => x > t), before = times.filter(x => x < t - 1e-6);
    assert.strictEqual(history.neighbour('sweep:', t, true), after.length ? Math.min(...after) : null);
    assert.strictEqual(history.neighbour('sweep:', t, false), before.length ? Math.max(...before) : null);
  }
}
{ // Of a live run, the last minute, and what was valid at its start.
  const history = new DriveHistory(60);
  for (let k = 0; k <= 3000; ++k) history.add('sweep:top', k * 0.1, k, 1000);
  history.add('HEALTH', 300, 'late', 10);
  assert.strictEqual(history.first, 240);
  assert.strictEqual(new Map(history.at(240.05)).get('sweep:top'), 2400);
  assert.ok(history.entries.get('sweep:top').length <= 602);
  assert.strictEqual(history.bytes, history.entries.get('sweep:top').length * 1000 + 10);
}
{ // Beyond the bytes the oldest become coarse, the start and the newest second stay.
  const history = new DriveHistory(Infinity, 1e6);
  for (let k = 0; k < 20000; ++k) {
    history.add('sweep:top', k * 0.1, k, 1000);
    assert.ok(history.bytes <= 1e6);
  }
  const list = history.entries.get('sweep:top');
  assert.strictEqual(list[0].value, 0);
  assert.deepStrictEqual(list.slice(-10).map(e => e.value), Array.from({length: 10}, (_, i) => 19990 + i));
  assert.strictEqual(list.reduce((sum, e) => sum + e.bytes, 0), history.bytes);
  for (let i = 1; i < list.length; ++i) assert.ok(list[i].t > list[i - 1].t);
}
{ // What cannot be thinned is kept, without end.
  const history = new DriveHistory(Infinity, 10);
  history.add('ALERTS', 1, 'a', 100);
  assert.deepStrictEqual(history.at(2), [['ALERTS', 'a']]);
  assert.deepStrictEqual(history.at(0.5), [['ALERTS', null]]);
}
console.log('ok');

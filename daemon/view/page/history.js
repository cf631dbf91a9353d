'use strict';
// What the page has received, kept within bounds, so that one can look back at it.

/** Values by key and time, s. Older than `maxAge` before the newest they are dropped; beyond `maxBytes`, every second one
 *  of the older half of each key is, so that a long drive is kept from its start, ever more coarsely. */
class DriveHistory {
  constructor(maxAge = Infinity, maxBytes = 128 * 2 ** 20) {
    this.maxAge = maxAge;
    this.maxBytes = maxBytes;
    this.clear();
  }

  clear() {
    this.entries = new Map();  // key → [{t, value, bytes}], oldest first
    this.bytes = 0;
    this.first = this.newest = null;
  }

  add(key, t, value, bytes) {
    if (!this.entries.has(key)) this.entries.set(key, []);
    const list = this.entries.get(key);
    // Reports of different devices are a little out of order.
    let at = list.length;
    while (at > 0 && list[at - 1].t > t) --at;
    list.splice(at, 0, {t, value, bytes});
    this.bytes += bytes;
    this.newest = Math.max(this.newest ?? t, t);
    this.first = Math.min(this.first ?? t, t);
    this.dropOld(list);
    while (this.bytes > this.maxBytes && this.thin());
  }

  /** The last one before the horizon stays: it is what was valid there. */
  dropOld(list) {
    const horizon = this.newest - this.maxAge;
    let old = 0;
    while (old + 1 < list.length && list[old + 1].t <= horizon) this.bytes -= list[old++].bytes;
    if (old > 0) list.splice(0, old);
    this.first = Math.max(this.first, horizon);
  }

  /** Returns false if nothing could be left out. */
  thin() {
    let dropped = 0;
    for (const [key, list] of this.entries) {
      const half = list.length >> 1;
      if (half < 8) continue;
      this.entries.set(key, list.filter((entry, i) => {
        const keep = i >= half || i % 2 === 0;
        if (!keep) { this.bytes -= entry.bytes; ++dropped; }
        return keep;
      }));
    }
    return dropped > 0;
  }

  /** Index of the last entry at or before `t`; −1 if there is none. */
  static indexAt(list, t) {
    let low = 0, high = list.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (list[middle].t <= t) low = middle + 1; else high = middle;
    }
    return low - 1;
  }

  /** What was valid at `t`: the last value of each key, or null, as [key, value]. */
  at(t) {
    const out = [];
    for (const [key, list] of this.entries) {
      const i = DriveHistory.indexAt(list, t);
      out.push([key, i >= 0 ? list[i].value : null]);
    }
    return out;
  }

  /** Time of the next (`forward`) or previous entry whose key begins with `prefix`, or null. */
  neighbour(prefix, t, forward) {
    let best = null;
    for (const [key, list] of this.entries) {
      if (!key.startsWith(prefix)) continue;
      const i = forward ? DriveHistory.indexAt(list, t) + 1 : DriveHistory.indexAt(list, t - 1e-6);
      const found = list[i]?.t;
      if (found !== undefined && (best === null || (forward ? found < best : found > best))) best = found;
    }
    return best;
  }
}

'use strict';
// Time: play, pause, step and seek, in what the page has kept and, in a replay, beyond it.

const liveSeconds = 60, playPeriod = 0.05;

class Player {
  /** `show(key, value)` shows what was valid at a time; `send` gives a command to the daemon; `moved` is called when another
   *  time is shown. */
  constructor(show, send, moved) {
    this.show = show;
    this.moved = moved;
    this.send = send;
    this.history = new DriveHistory(liveSeconds);
    this.begin(false);
    const at = (id, event, action) => place(id).addEventListener(event, action);
    at('pause', 'click', () => this.pause(!this.paused));
    at('back', 'click', () => this.step(false));
    at('step', 'click', () => this.step(true));
    at('newest', 'click', () => this.follow());
    at('rate', 'change', () => this.sendRate());
    at('goto', 'change', e => { if (e.target.value !== '') this.goTo((driveStart ?? 0) + Number(e.target.value)); });
    at('finish', 'click', () => this.goTo((this.history.newest ?? 0) + 1e7));
    at('next', 'click', () => this.nextAlert());
    setInterval(() => this.tick(), 1000 * playPeriod);
  }

  /** A daemon begins to send. */
  begin(replay) {
    this.replay = replay;
    this.history.maxAge = replay ? Infinity : liveSeconds;
    this.history.clear();
    this.paused = this.seekingAlert = this.ended = false;
    this.runningTo = null;  // where a seek beyond the newest goes, s
    this.cursor = null;  // time that is shown, s; null: the newest
    this.sent = null;
    place('replay').hidden = !replay;
    this.label();
  }

  /** The drive has ended: nothing new comes. */
  end() {
    this.ended = true;
    this.runningTo = null;
    this.label();
  }

  add(key, t, value, bytes) {
    this.history.add(key, t, value, bytes);
    if (this.cursor === null) {
      shownAt = Infinity;
      this.show(key, value);
    }
  }

  addAlert(t) {
    if (!this.seekingAlert) return;
    this.seekingAlert = false;  // the daemon has paused by itself
    this.paused = true;
    setTimeout(() => this.goTo(t), 300);  // when what belongs to it has arrived
  }

  pause(paused) {
    this.paused = paused;
    // Live goes on: what is shown is held here.
    if (paused && !this.replay && this.cursor === null) this.cursor = this.history.newest;
    this.sendRate();
  }

  /** A replay waits while somebody looks back. */
  sendRate() {
    this.label();
    if (!this.replay || this.ended) return;
    const rate = this.paused || this.cursor !== null ? 0 : Number(place('rate').value);
    if (rate !== this.sent) this.send({rate});
    this.sent = rate;
    this.runningTo = null;
  }

  step(forward) {
    this.paused = true;
    const now = this.cursor ?? this.history.neighbour('sweep:', Infinity, false);
    const found = now === null ? null : this.history.neighbour('sweep:', now, forward);
    if (found !== null) return this.goTo(found);
    if (!forward || !this.replay || this.ended) return this.sendRate();
    this.follow();
    this.send({step: true});
    this.sent = null;  // whatever is asked for next ends the step
  }

  /** Shows the time `t`; beyond the newest a replay runs there as fast as it can. */
  goTo(t) {
    if (this.history.newest === null) return;
    if (t > this.history.newest) {
      this.follow();
      if (!this.replay || this.ended) return;
      this.send({seek: String(Math.round(t * 1e3)) + '000000'});
      this.runningTo = t;
      return this.label();
    }
    this.cursor = shownAt = Math.max(t, this.history.first);
    for (const [key, value] of this.history.at(this.cursor + 1e-6)) this.show(key, value);
    this.moved();
    this.sendRate();
  }

  /** Shows a time that was kept, and stays there. */
  hold(t) {
    this.paused = true;
    this.goTo(t);
  }

  nextAlert() {
    this.follow();
    this.seekingAlert = true;
    this.sent = null;  // the daemon ends it paused
    this.send({seek: 'alert'});
  }

  /** Shows the newest again. */
  follow() {
    this.cursor = null;
    shownAt = Infinity;
    for (const [key, value] of this.history.at(Infinity)) this.show(key, value);
    this.moved();
    if (!this.replay) this.paused = false;
    this.sendRate();
  }

  tick() {
    if (this.cursor !== null && !this.paused) {
      const next = this.cursor + playPeriod * Number(place('rate').value);
      if (next >= this.history.newest) this.follow(); else this.goTo(next);
    }
    this.label();
  }

  /** When the oldest sweep or image that can be shown was taken. */
  kept() {
    const times = [...this.history.entries].filter(([key]) => /^(sweep|image):/.test(key)).map(([, list]) => list[0].t);
    return times.length ? Math.min(...times) : Infinity;
  }

  label() {
    const {first, newest} = this.history, now = this.cursor ?? newest;
    if (this.runningTo !== null && newest >= this.runningTo) {
      this.runningTo = null;
      this.paused = Number(place('rate').value) === 0 || this.paused;
    }
    place('pause').textContent = this.paused || this.ended ? 'Play' : 'Pause';
    place('newest').disabled = this.cursor === null;
    place('finish').disabled = place('next').disabled = this.ended;
    timeline.update(newest === null ? null : Math.min(driveStart ?? first, first), newest, this.kept(), now);
    if (newest === null) { place('cursor').textContent = this.replay ? 'the replay begins' : ''; return; }
    const what = this.cursor !== null ? (this.paused ? 'looking back' : 'playing back') : this.ended ? 'the end' : this.seekingAlert ? 'to the next alert'
      : this.runningTo !== null ? `running to ${this.runningTo > newest + 1e6 ? 'the end' : timeText(this.runningTo)}`
        : this.paused ? 'paused' : this.replay ? 'playing' : 'live';
    place('cursor').textContent = `${timeText(now)} ${what}`;
  }
}

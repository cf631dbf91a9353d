'use strict';
// Time: play, pause, step and seek, in what the page has kept and, in a replay, beyond it.

const liveSeconds = 60, playPeriod = 0.05, maxAlerts = 200;

class Player {
  /** `show(key, value)` shows what was valid at a time; `send` gives a command to the daemon. */
  constructor(show, send) {
    this.show = show;
    this.send = send;
    this.history = new DriveHistory(liveSeconds);
    this.begin(false);
    const at = (id, event, action) => place(id).addEventListener(event, action);
    at('pause', 'click', () => this.pause(!this.paused));
    at('back', 'click', () => this.step(false));
    at('step', 'click', () => this.step(true));
    at('newest', 'click', () => this.follow());
    at('rate', 'change', () => this.sendRate());
    at('seek', 'input', e => this.goTo(Number(e.target.value)));
    at('jump', 'change', e => { if (e.target.value) this.goTo(Number(e.target.value)); e.target.value = ''; });
    at('goto', 'change', e => { if (e.target.value !== '') this.goTo((start ?? 0) + Number(e.target.value)); });
    at('next', 'click', () => this.nextAlert());
    setInterval(() => this.tick(), 1000 * playPeriod);
  }

  /** A daemon begins to send. */
  begin(replay) {
    this.replay = replay;
    this.history.maxAge = replay ? Infinity : liveSeconds;
    this.history.clear();
    this.paused = this.seekingAlert = false;
    this.cursor = null;  // time that is shown, s; null: the newest
    this.sent = null;
    place('replay').hidden = !replay;
    while (place('jump').options.length > 1) place('jump').remove(1);
    this.label();
  }

  add(key, t, value, bytes) {
    this.history.add(key, t, value, bytes);
    if (this.cursor === null) {
      shownAt = Infinity;
      this.show(key, value);
    }
  }

  addAlert(t, text) {
    const jump = place('jump');
    jump.append(element('option', {value: t}, text));
    if (jump.options.length > maxAlerts) jump.remove(1);
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
    if (!this.replay) return;
    const rate = this.paused || this.cursor !== null ? 0 : Number(place('rate').value);
    if (rate !== this.sent) this.send({rate});
    this.sent = rate;
  }

  step(forward) {
    this.paused = true;
    const now = this.cursor ?? this.history.neighbour('sweep:', Infinity, false);
    const found = now === null ? null : this.history.neighbour('sweep:', now, forward);
    if (found !== null) return this.goTo(found);
    if (!forward || !this.replay) return this.sendRate();
    this.follow();
    this.send({step: true});
    this.sent = null;  // whatever is asked for next ends the step
  }

  /** Shows the time `t`; beyond the newest a replay runs there as fast as it can. */
  goTo(t) {
    if (this.history.newest === null) return;
    if (t > this.history.newest) {
      this.follow();
      if (this.replay) this.send({seek: String(Math.round(t * 1e3)) + '000000'});
      return;
    }
    this.cursor = shownAt = Math.max(t, this.history.first);
    for (const [key, value] of this.history.at(this.cursor)) this.show(key, value);
    this.sendRate();
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

  label() {
    const {first, newest} = this.history, slider = place('seek'), now = this.cursor ?? newest;
    place('pause').textContent = this.paused ? 'Play' : 'Pause';
    place('newest').disabled = this.cursor === null;
    slider.disabled = newest === null;
    if (newest === null) return;
    slider.min = first;
    slider.max = newest;
    slider.value = now;
    place('cursor').textContent = `${(now - (start ?? now)).toFixed(1)} s ` +
      (this.cursor !== null ? 'looking back' : this.seekingAlert ? 'to the next alert' : this.paused ? 'paused' : this.replay ? 'playing' : 'live');
  }
}

'use strict';
// The timeline: the drive from its start, with the speed, the states as bands, and the alerts as ticks.

const stateColour = name => `var(--${levelClass[name] ?? 'idle'})`;

/** What has been reported over time, whether or not it is shown now. */
class Course {
  constructor() { this.clear(); }

  clear() {
    this.speed = [];         // [t, m/s]
    this.states = new Map();  // row → [{t, name}], changes only
    this.alerts = [];        // {id, t, until, device, what, severity, advice}
    this.revision = 0;
  }

  addState(row, t, name) {
    if (!this.states.has(row)) this.states.set(row, []);
    const list = this.states.get(row), last = list.at(-1);
    if (last && t < last.t) return;
    if (!last || last.name !== name) list.push({t, name});
    ++this.revision;
  }

  addSpeed(t, speed) {
    const last = this.speed.at(-1);
    if (!Number.isFinite(speed) || (last && t <= last[0])) return;
    this.speed.push([t, speed]);
    if (this.speed.length > 8000) this.speed = this.speed.filter((_, i) => i % 2 || i > 4000);
    ++this.revision;
  }

  /** An alert that is already known is not added again. */
  addAlert(message) {
    const t = seconds(message.stamp), open = this.alerts.find(a => a.id === message.id && a.until === undefined);
    if (message.state !== 'raised') { if (open) open.until = t; } else if (!open) {
      this.alerts.push({id: message.id, t, device: message.device, what: message.what, severity: message.severity});
    }
    ++this.revision;
  }

  /** Spans of equal state of a row until `end`: [{from, to, name, colour}]. */
  spans(row, end) {
    const list = this.states.get(row) ?? [];
    return list.map(({t, name}, i) => ({from: t, to: list[i + 1]?.t ?? Math.max(t, end), name, colour: stateColour(name)}));
  }
}

class Timeline {
  /** `goTo(t)` is called while somebody scrubs. */
  constructor(canvas, course, goTo) {
    Object.assign(this, {canvas, course});
    const scrub = e => { if (this.range) goTo(this.timeAt(e.offsetX)); };
    canvas.addEventListener('pointerdown', e => { canvas.setPointerCapture(e.pointerId); this.held = true; scrub(e); });
    canvas.addEventListener('pointermove', e => { if (this.held) scrub(e); this.showValue(e.offsetX, e.offsetY); });
    canvas.addEventListener('pointerleave', () => { place('timeline-value').textContent = ''; });
    for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, () => { this.held = false; });
    new ResizeObserver(() => { this.drawn = null; this.draw(); }).observe(canvas);
  }

  timeAt(u) {
    const {first, last} = this.range, {left, right} = this;
    return Math.min(last, Math.max(first, first + (last - first) * (u - left) / (right - left)));
  }

  showValue(u, v) {
    if (!this.range) return;
    const t = this.timeAt(u);
    const near = this.course.alerts.filter(a => Math.abs(this.x(a.t) - u) < 6);
    const speed = this.course.speed.filter(([at]) => at <= t + 0.5).at(-1);
    place('timeline-value').textContent = near.length ? near.map(a => `${timeText(a.t)} ${a.severity} ${a.device}: ${a.what}`).join('; ')
      : `${timeText(t)}${speed ? `, ${speed[1].toFixed(1)} m/s` : ''}`;
  }

  x(t) { return this.left + (this.right - this.left) * (t - this.range.first) / (this.range.last - this.range.first); }

  /** `first`, `last`: of the drive so far; `kept`: from when on sweeps and images can be shown again; `now`: what is shown. */
  update(first, last, kept, now) {
    this.range = first === null ? null : {first, last: Math.max(last, first + 1), kept};
    this.now = now;
    this.draw();
  }

  draw() {
    const {canvas, course} = this, width = canvas.clientWidth;
    if (!width || !this.range) return;
    const rows = ['health', ...[...course.states.keys()].filter(row => row !== 'health')], top = 12, speedHeight = 30, band = 11, height = top + speedHeight + band * rows.length + 18;
    const key = [course.revision, width, this.range.last, this.range.kept, isLight(), this.now].join();
    if (key === this.drawn) return;
    this.drawn = key;
    canvas.style.height = `${height}px`;
    const ratio = fitCanvas(canvas), context = canvas.getContext('2d'), style = getComputedStyle(document.documentElement);
    const colour = name => style.getPropertyValue(`--${name}`);
    [this.left, this.right] = [Math.min(110, width / 4), width - 14];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = '11px system-ui, sans-serif';
    context.textBaseline = 'middle';
    const {first, last, kept} = this.range;
    context.fillStyle = colour('panel');
    context.fillRect(this.left, top, this.right - this.left, height - top - 18);
    if (kept > first) {  // reports only
      context.fillStyle = colour('line');
      context.globalAlpha = 0.5;
      context.fillRect(this.left, top, this.x(Math.min(kept, last)) - this.left, speedHeight);
      context.globalAlpha = 1;
    }
    this.drawSpeed(context, colour, top, speedHeight);
    rows.forEach((row, i) => {
      const y = top + speedHeight + i * band;
      context.fillStyle = colour('dim');
      context.textAlign = 'right';
      context.fillText(row, this.left - 6, y + band / 2);
      context.textAlign = 'left';
      for (const span of course.spans(row, last)) {
        context.fillStyle = colour(levelClass[span.name] ?? 'idle');
        context.fillRect(this.x(span.from), y + 1, Math.max(1, this.x(span.to) - this.x(span.from) - 0.5), band - 2);
        context.font = '9px system-ui, sans-serif';
        if (context.measureText(span.name).width + 6 < this.x(span.to) - this.x(span.from)) {
          context.fillStyle = isLight() ? '#fff' : '#000';
          context.fillText(span.name, this.x(span.from) + 3, y + band / 2 + 0.5);
        }
        context.font = '11px system-ui, sans-serif';
      }
    });
    for (const alert of course.alerts) {
      const u = this.x(alert.t);
      context.fillStyle = colour(alert.severity === 'WARN' ? 'warn' : 'bad');
      context.beginPath();
      context.moveTo(u, top);
      context.lineTo(u - 5, top - 10);
      context.lineTo(u + 5, top - 10);
      context.fill();
      context.fillRect(u - 0.5, top, 1, height - top - 18);
    }
    const step = ticks(0, last - first, Math.max(2, Math.min(12, width / 90)));
    context.fillStyle = colour('dim');
    context.textAlign = 'center';
    for (const t of step.values) {
      const u = this.x(first + t);
      context.fillRect(u, height - 18, 1, 4);
      context.fillText(`${t.toFixed(step.digits)}${t === step.values.at(-1) ? ' s' : ''}`, Math.min(u, this.right - 12), height - 7);
    }
    const u = this.x(this.now);
    context.fillStyle = colour('text');
    context.fillRect(u - 1, top - 2, 2, height - top - 14);
    context.beginPath();
    context.arc(u, top - 4, 4, 0, 2 * Math.PI);
    context.fill();
    canvas.setAttribute('aria-valuenow', (this.now - first).toFixed(1));
    canvas.setAttribute('aria-valuemax', (last - first).toFixed(1));
  }

  drawSpeed(context, colour, top, height) {
    const highest = this.course.speed.reduce((a, p) => Math.max(a, p[1]), 0);
    context.fillStyle = colour('dim');
    context.textAlign = 'right';
    context.fillText(this.course.speed.length ? `speed ≤ ${highest.toFixed(0)} m/s` : 'no speed', this.left - 6, top + height / 2);
    if (highest <= 0) return;
    context.beginPath();
    context.moveTo(this.x(this.course.speed[0][0]), top + height);
    for (const [t, v] of this.course.speed) context.lineTo(this.x(t), top + height - Math.max(0, v) / highest * (height - 4));
    context.lineTo(this.x(this.course.speed.at(-1)[0]), top + height);
    context.fillStyle = colour('odom');
    context.globalAlpha = 0.35;
    context.fill();
    context.globalAlpha = 1;
  }
}

'use strict';
// The calibration panel: the evidence for a drift over time, and the drift along each axis.

const axisNames = ['rotation about x', 'rotation about y', 'rotation about z', 'translation along x', 'translation along y', 'translation along z'];

/** "+0.50 ± 0.10° about y": the error of a calibration along an axis of a report. */
function offsetText(report, axis = axisNames.indexOf(report.evidence?.axis)) {
  if (!report.offset || axis < 0 || !(report.offset_sigma[axis] < 1e3)) return '';
  const [factor, digits, unit] = axis < 3 ? [180 / Math.PI, 2, '°'] : [100, 1, ' cm'];
  const [value, sigma] = [report.offset[axis] * factor, report.offset_sigma[axis] * factor];
  return `${report.offset_at_least ? 'at least ' : ''}${value < 0 ? '−' : '+'}${Math.abs(value).toFixed(digits)} ± ${sigma.toFixed(digits)}${unit} ${axis < 3 ? 'about' : 'along'} ${'xyz'[axis % 3]}`;
}

/** ", since …": when the drift that is being repaired was confirmed. */
function confirmedText({device, stamp}, course) {
  const begun = course.states.get(device)?.findLast(s => s.name === 'CONFIRMED' && s.t <= seconds(stamp));
  return begun ? `, since ${timeText(begun.t)}` : '';
}

/** What a calibration report says, in one sentence: [class, text]. */
function verdict(report, course) {
  const since = report.since !== undefined ? `, since ${timeText(seconds(report.since))}` : '', by = offsetText(report);
  const wrong = by ? `wrong by ${by}` : 'wrong';
  switch (report.state) {
    case 'OK': return ['good', 'calibration right'];
    case 'MONITORING': return ['idle', 'calibration not judged yet'];
    case 'SUSPECTED': return ['warn', `calibration perhaps ${wrong}${since}`];
    case 'CONFIRMED': return ['bad', `calibration ${wrong}${since}`];
    case 'RECALIBRATING': return ['bad', `calibration ${wrong}${confirmedText(report, course)}; a new one is being estimated`];
    case 'RECALIBRATED': return ['warn', `new calibration on probation${since}`];
    default: return ['bad', `calibration cannot be monitored${since}`];
  }
}

class CalibrationPanel {
  constructor(place, course) {
    this.place = place;
    this.course = course;
    this.cameras = new Map();  // device → {points: [{t, nats, threshold}], report, profile, parts}
  }

  clear() {
    this.cameras.clear();
    this.place.replaceChildren();
  }

  camera(device) {
    if (!this.cameras.has(device)) this.cameras.set(device, {points: []});
    return this.cameras.get(device);
  }

  /** Keeps what is drawn over time. */
  add(report) {
    const {points} = this.camera(report.device), t = seconds(report.stamp);
    if (report.evidence && !(points.length && points.at(-1).t >= t)) {
      points.push({t, nats: report.evidence.nats, threshold: report.evidence.threshold_nats, axis: report.evidence.axis});
    }
  }

  /** Draws anew: `start`, `last`: of the drive, s; `now`: what is shown. */
  show(start, last, now) {
    if (this.cameras.size === 0) {
      this.place.replaceChildren(emptyState('No calibration is monitored.', 'Monitoring needs a lidar and a camera with a calibration ' +
        '([[camera]] with lidar and T_camera_lidar) and begins with the first image. infused(8) describes [calibration].'));
      return;
    }
    const size = this.sizes();
    this.place.replaceChildren(...[...this.cameras].map(([device, camera]) => this.showCamera(device, camera, start, last, now, size)));
  }

  /** Pixels of the charts, so that their text has its size: the evidence beside the profiles where there is room. */
  sizes() {
    const width = this.place.clientWidth - 18, height = this.place.clientHeight, beside = width > 560, one = this.cameras.size === 1;
    const right = beside ? (width - 12) * 6 / 11 : width, columns = beside ? 3 : Math.max(2, Math.min(6, Math.floor(right / 160)));
    // Verdict, title and margins; and a legend, where there are more than two calibrations.
    const above = [...this.cameras.values()].some(({profile}) => Object.keys(profile?.header.profiles ?? {}).length > 2) ? 106 : 84;
    return {time: {width: beside ? width * 5 / 11 : width, height: beside && one ? Math.min(420, Math.max(110, height - 44)) : 190},
      profile: {width: Math.floor((right - 6 * (columns - 1)) / columns) - 1, height: beside && one ? Math.min(200, Math.max(76, (height - above) / 2)) : 110}, columns, beside};
  }

  showCamera(device, {points, report, profile}, start, last, now, size) {
    const duration = Math.max(5, last - start), relative = p => p.t - start;
    const parts = [], head = [];
    if (report) {
      const [kind, text] = verdict(report, this.course);
      head.push(element('p', {class: 'verdict'}, element('b', {}, device), ' ', element('span', {class: kind}, `${marks[kind]} ${text}`),
        report.frozen ? ' (frozen)' : '', report.proposed ? element('span', {class: 'warn'}, ' A new calibration is proposed: infuse apply.') : ''));
    }
    if (points.length) {
      const threshold = points.at(-1).threshold;
      parts.push(timeChart({title: `Evidence for a drift of ${device}`, unit: 'nats', duration, zero: true, ...size.time,
        spans: this.course.spans(device, last).map(s => ({...s, from: s.from - start, to: s.to - start})),
        lines: [{points: points.map(p => [relative(p), p.nats]), colour: 'var(--odom)', dots: true},
          {points: [...points.map(p => [relative(p), p.threshold]), [duration, threshold]], colour: 'var(--bad)', dash: true,
            label: `confirmed above ${threshold?.toFixed(1)}`}],
        cursor: now - start}));
    } else {
      parts.push(emptyState('No evidence yet.', 'The first evaluation comes with the first image that has a sweep.'));
    }
    return element('div', {class: size.beside ? 'calibrated' : 'calibrated narrow'}, ...head, element('div', {}, ...parts), element('div', {}, ...profileElements(profile, report, size.profile)));
  }
}

/** What is missing, and how to add it. */
function emptyState(what, how) {
  return element('p', {class: 'empty'}, element('b', {}, what), ' ', how);
}

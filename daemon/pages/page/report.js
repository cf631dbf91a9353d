'use strict';
// The page of infuse report, from the data that the page contains.

const data = JSON.parse(document.getElementById('data').textContent);
const place = id => document.getElementById(id);
const remove = id => place(id).remove();
const last = values => values[values.length - 1];
const stateColours = {OK: 'var(--good)', MONITORING: 'var(--dim)', SUSPECTED: 'var(--warn)', CONFIRMED: 'var(--bad)',
  RECALIBRATING: 'var(--odom)', RECALIBRATED: 'var(--odom)', UNUSABLE: 'var(--bad)', WARN: 'var(--warn)', ERROR: 'var(--bad)', STALE: 'var(--bad)',
  TRACKING: 'var(--good)', UNSURE: 'var(--warn)', LOST: 'var(--bad)'};
const mapOffset = '#d33a2c';  // on the map's image, which has the same colours in light and dark

/** Spans of equal state: [{from, to, name, colour}]. */
function stateSpans(points, key) {
  const spans = [];
  for (const point of points) {
    const name = point[key];
    if (spans.length && last(spans).name === name) continue;
    if (spans.length) last(spans).to = point.t;
    spans.push({from: point.t, to: data.duration, name, colour: stateColours[name] ?? 'var(--dim)'});
  }
  return spans;
}

function rms(values) {
  return Math.sqrt(values.reduce((sum, v) => sum + v * v, 0) / values.length);
}

function movedText(moved) {
  return `${moved.rotation_deg.toFixed(2)}° and ${moved.translation_cm.toFixed(1)} cm`;
}

/** Events in the order of time: [{t, text, kind}]. */
function storyEvents() {
  const events = [];
  for (const knock of data.true_moves ?? []) {
    events.push({t: knock.t, kind: 'warn', text: `Truth: the camera ${knock.device} is moved, by ${movedText(knock.moved)}. ` +
      'infuse does not know.'});
  }
  for (const camera of data.cameras) {
    for (const span of stateSpans(camera.points, 'state').filter(s => s.name === 'RECALIBRATING')) {
      events.push({t: span.from, kind: 'warn', text: `${camera.device}: re-estimation starts in the background`});
    }
    for (const change of camera.history) {
      const moved = change.moved.rotation_deg > 1e-6 || change.moved.translation_cm > 1e-6
        ? `; the calibration in use moves by ${movedText(change.moved)}` : '';
      events.push({t: change.t, kind: change.state === 'OK' ? 'good' : 'warn', text: `${camera.device}: ${change.what}${moved}`});
    }
  }
  for (const alert of data.alerts) {
    if (alert.state === 'raised') {
      events.push({t: alert.t, kind: alert.severity !== 'WARN' ? 'bad' : 'warn',
        text: `Alert: ${alert.device}: ${alert.what}`});
    } else {
      events.push({t: alert.t, kind: 'good', text: `Alert cleared: ${alert.device}: ${alert.what.split(':')[0]}`});
    }
  }
  for (const state of data.map.states) {
    events.push({t: state.t, kind: state.state === 'TRACKING' ? 'good' : 'warn', text: `Street map: ${state.state}`});
  }
  return events.sort((a, b) => a.t - b.t);
}

function showHead() {
  place('title').textContent = data.name;
  document.title = `infuse: ${data.name}`;
  const names = (Array.isArray(data.devices) ? data.devices : []).map(d => `${d.device} (${d.model || d.kind})`).join(', ');
  place('summary').textContent = `${data.duration.toFixed(1)} s of drive, ${data.reports} reports. ${names}`;
  const events = storyEvents();
  const shown = events.slice(0, 60);
  for (const event of shown) {
    place('story').append(element('li', {}, element('time', {}, `${event.t.toFixed(1)} s`),
      element('span', {class: event.kind}, event.text)));
  }
  if (events.length > shown.length) place('story').append(element('li', {}, element('time'), `and ${events.length - shown.length} more`));
  if (events.length === 0) place('story').append(element('li', {}, element('time'), 'No alert and no change of a calibration.'));
}

function showPath() {
  const onMap = data.map.x.length > 1, truth = data.truth ?? null;
  const odom = data.odom_on_truth ?? (onMap ? null : data.odom);
  const paths = [], names = [];
  const add = (path, colour, width, name) => {
    if (!path || path.x.length < 2) return;
    paths.push({x: path.x, y: path.y, colour, width});
    names.push([colour, name]);
  };
  const truthColour = data.map_image ? '#fff' : 'var(--truth)';
  add(truth, truthColour, 6, 'true path');
  add(odom, data.map_image ? '#1f4fa8' : 'var(--odom)', 2, truth ? 'odometry, from the true first pose' : 'odometry');
  if (onMap) add(data.map, data.map_image ? mapOffset : 'var(--map)', 2.5, 'infuse on the street map, with 99 % ellipses');
  if (paths.length === 0) return remove('path');
  const ellipses = [];
  const every = Math.max(1, Math.floor(data.map.x.length / 16));
  for (let i = 0; onMap && i < data.map.x.length; i += every) {
    ellipses.push({x: data.map.x[i], y: data.map.y[i], xx: data.map.xx[i], xy: data.map.xy[i], yy: data.map.yy[i],
      colour: mapOffset});
  }
  const lines = [];
  const texts = [];
  const addErrors = (errors, colour, name) => {
    if (!errors || errors.m.length === 0) return;
    lines.push({points: errors.t.map((t, i) => [t, errors.m[i]]), colour});
    texts.push(`${name}: rms ${rms(errors.m).toFixed(2)} m, maximum ${Math.max(...errors.m).toFixed(2)} m`);
  };
  addErrors(data.odom_errors, 'var(--odom)', 'odometry, from the true first pose');
  addErrors(onMap ? data.map_errors : null, 'var(--map)', 'on the street map');
  place('path-note').textContent = texts.length ? `Distance from the true position. ${texts.join('; ')}.`
    : 'There is no truth to compare with.';
  place('path-map').append(planChart({paths, ellipses, image: data.map_image}), legend(names));
  if (lines.length === 0) return;
  place('path-errors').append(timeChart({title: 'Distance from the true position', unit: 'm', duration: data.duration, lines,
    zero: true, spans: onMap ? stateSpans(data.map.states, 'state') : []}));
}

function overlayFigure(image) {
  const box = element('div', {class: 'compare'}, element('img', {src: image.before, alt: 'lidar over image, before'}));
  const figure = element('figure', {}, box);
  const at = `${image.device}, ${image.t.toFixed(1)} s`;
  if (!image.after) {
    figure.append(element('figcaption', {}, `${at}, with the calibration in use`));
    return figure;
  }
  const after = element('img', {src: image.after, class: 'after', alt: 'lidar over image, after'});
  const slider = element('input', {type: 'range', min: 0, max: 100, value: 50, 'aria-label': 'before and after'});
  const cut = () => { after.style.clipPath = `inset(0 0 0 ${slider.value}%)`; };
  slider.addEventListener('input', cut);
  cut();
  box.append(after);
  figure.append(slider, element('figcaption', {}, `${at}. Left of the slider: the calibration at the start; right: the one ` +
    'at the end of the replay.'));
  return figure;
}

const axisNames = ['rotation about x', 'rotation about y', 'rotation about z', 'translation along x', 'translation along y',
  'translation along z'];

function offsetChart(camera, axis) {
  const factor = axis < 3 ? 180 / Math.PI : 100;
  const points = camera.points.filter(p => p.offset && p.sigma && p.sigma[axis] < 1e3);
  return timeChart({title: axisNames[axis], unit: axis < 3 ? 'degrees' : 'cm', duration: data.duration, width: 400, height: 180,
    lines: [{points: points.map(p => [p.t, p.offset[axis] * factor]), colour: 'var(--odom)', dots: true},
      {points: [[0, 0], [data.duration, 0]], colour: 'var(--dim)', dash: true}],
    bands: [{points: points.map(p => [p.t, (p.offset[axis] - 2 * p.sigma[axis]) * factor,
      (p.offset[axis] + 2 * p.sigma[axis]) * factor]), colour: 'var(--odom)'}]});
}

function showCamera(camera) {
  const marks = (data.true_moves ?? []).filter(m => m.device === camera.device).map(m => ({t: m.t, name: 'camera moved (truth)'}));
  const evidence = camera.points.filter(p => p.nats !== undefined);
  const parts = [element('h3', {}, `Camera ${camera.device}`)];
  if (evidence.length) {
    parts.push(element('p', {class: 'note'}, 'Evidence that the camera has moved against the lidar, along the axis with the ' +
      'most. Above the threshold (dashed) the drift is confirmed. A point is a report; hold the pointer over it for its axis.'),
      timeChart({title: 'Evidence for a drift', unit: 'nats', duration: data.duration, zero: true,
        spans: stateSpans(camera.points, 'state'), marks,
        lines: [{points: evidence.map(p => [p.t, p.nats, `${p.axis}: ${p.nats} nats`]), colour: 'var(--odom)', dots: true},
          {points: evidence.map(p => [p.t, p.threshold_nats]).concat([[data.duration, last(evidence).threshold_nats]]),
            colour: 'var(--bad)', dash: true}]}));
  }
  const images = (data.overlays ?? []).filter(p => p.device === camera.device);
  if (images.length) {
    parts.push(element('h3', {}, 'Lidar over the image'), element('p', {class: 'note'},
      'Returns coloured by distance, red near and blue far. Where they jump from near to far, the image should have an edge.'),
      ...images.map(overlayFigure));
  }
  if (evidence.length > 1) {
    parts.push(element('h3', {}, 'Estimated error of the calibration in use, per axis'),
      element('p', {class: 'note'}, 'With two standard deviations. Axes of the camera: x right, y down, z ahead.'),
      element('div', {class: 'row'}, ...axisNames.map((_, axis) => offsetChart(camera, axis))));
  }
  if (camera.history.length) {
    parts.push(element('h3', {}, 'Changes'), table(['time', 'state after', 'what', 'calibration in use moved'],
      camera.history.map(c => [`${c.t.toFixed(1)} s`, c.state, c.what,
        c.moved.rotation_deg > 1e-6 || c.moved.translation_cm > 1e-6 ? movedText(c.moved) : 'no'])));
  }
  place('cameras').append(...parts);
}

function showOdometry() {
  if (data.odometry.length < 2) return remove('odometry');
  const odometry = data.health?.odometry ?? {};
  const charts = [['speed', 'speed', 'm/s', 1, true], ['wheel_scale', 'wheel scale, true over measured', '', 1, false],
    ['yaw_rate_bias', 'bias of the yaw-rate sensor', '°/s', 180 / Math.PI, false],
    ['gyro_bias', 'bias of the gyroscope', '°/s', 180 / Math.PI, false]];
  for (const [key, title, unit, factor, zero] of charts) {
    const points = data.odometry.filter(p => p[key] !== undefined);
    if (points.length < 2) continue;
    const sigma = `${key}_sigma`;
    place('motion').append(timeChart({title, unit, duration: data.duration, zero, width: 400, height: 180,
      lines: [{points: points.map(p => [p.t, p[key] * factor]), colour: 'var(--odom)'}],
      bands: points[0][sigma] === undefined ? [] : [{colour: 'var(--odom)',
        points: points.map(p => [p.t, (p[key] - 2 * p[sigma]) * factor, (p[key] + 2 * p[sigma]) * factor])}]}));
  }
  const text = odometry.usable ? 'Usable at the end.' : `Not usable at the end: ${odometry.reason ?? 'unknown'}.`;
  place('sources').append(element('p', {class: 'note'},
    `${text} Bands are two standard deviations. Outliers ${odometry.outliers ?? 0}, late samples ${odometry.late ?? 0}, ` +
    `sweeps not deskewed ${odometry.sweeps_not_deskewed ?? 0}.`));
  if (Array.isArray(odometry.sources) && odometry.sources.length) {
    const head = Object.keys(odometry.sources[0]);
    place('sources').append(table(head, odometry.sources.map(s => head.map(k => typeof s[k] === 'object' ? '' : String(s[k] ?? '')))));
  }
}

function showHealth() {
  const spans = stateSpans(data.levels, 'level');
  place('levels').append(element('p', {class: 'note'}, `Level of the whole: ${spans.slice(0, 20).map(s =>
    `${s.name} from ${s.from.toFixed(0)} s`).join(', ') || 'not reported'}.`));
  place('alerts').append(data.alerts.length === 0 ? element('p', {}, 'No alert.') : table(
    ['since', 'until', 'severity', 'device', 'what', 'what to do'],
    data.alerts.filter(a => a.state === 'raised').map(a => {
      const end = data.alerts.find(b => b.state !== 'raised' && b.id === a.id && b.t >= a.t);
      return [`${(a.since ?? a.t).toFixed(1)} s`, end ? `${end.t.toFixed(1)} s` : 'still raised', a.severity, a.device, a.what, a.advice];
    })));
  const sensors = data.health?.sensors ?? [], streams = data.health?.streams ?? [];
  const lost = s => Object.entries(s.losses ?? {}).filter(e => e[1] > 0).map(e => `${e[0]} ${e[1]}`).join(', ') || 'none';
  place('sensors').append(element('h3', {}, 'Sensors at the end'), table(['device', 'kind', 'level', 'rate', 'used', 'lost'],
    sensors.map(s => [s.device, 'lidar', s.level, `${s.sweeps_hz} sweeps/s`, `${s.sweeps} sweeps`, lost(s)]).concat(
      streams.map(s => [s.device, s.kind, s.level, `${s.received_hz} /s`, `${s.used} of ${s.received}`,
        s.lost > 0 ? String(s.lost) : 'none']))));
}

showHead();
showPath();
if (data.cameras.length) data.cameras.forEach(showCamera); else remove('calibration');
showOdometry();
if (data.sweep) place('sweep-image').append(element('img', {src: data.sweep, alt: 'sweep from above'})); else remove('sweep');
showHealth();
place('notes').textContent = [...(data.notes ?? []),
  data.left_out ? `${data.left_out} reports are beyond what is drawn.` : '',
  data.unreadable ? `${data.unreadable} lines of the reports file are damaged.` : ''].filter(Boolean).join(' ');

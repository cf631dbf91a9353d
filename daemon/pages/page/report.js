'use strict';
// The page of infuse report, from the data that the page contains.

const data = JSON.parse(document.getElementById('data').textContent);
const place = id => document.getElementById(id);
const remove = id => place(id).remove();
const last = values => values[values.length - 1];
const stateColours = {OK: 'var(--good)', MONITORING: 'var(--dim)', SUSPECTED: 'var(--warn)', CONFIRMED: 'var(--bad)',
  RECALIBRATING: 'var(--odom)', RECALIBRATED: 'var(--odom)', UNUSABLE: 'var(--bad)', WARN: 'var(--warn)', ERROR: 'var(--bad)', STALE: 'var(--bad)',
  TRACKING: 'var(--good)', UNSURE: 'var(--warn)', LOST: 'var(--bad)'};
const mapOffset = '#d55e00';  // on the map's image, which has the same colours in light and dark

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
  const parts = [moved.rotation_deg >= 0.005 ? `${moved.rotation_deg.toFixed(2)}°` : '', moved.translation_cm >= 0.05 ? `${moved.translation_cm.toFixed(1)} cm` : ''];
  return parts.filter(Boolean).join(' and ') || 'nothing';
}

/** "15.6 s", on one line. */
const timeText = t => `${(Math.round(10 * t + 1e-6) / 10).toFixed(1)}\u00a0s`;
const utc = t => new Date(Number(BigInt(data.begin_ns) / 1000000n) + 1000 * t).toISOString().slice(0, 19).replace('T', ' ');

/** What happened to one device at one time is one event: a change of its calibration says more than the alert that is
 *  raised by it, and this more than one that is cleared by it. */
function oneOfEach(events) {
  const rank = {change: 0, raised: 1, cleared: 2};
  const kept = [];
  for (const event of events.sort((a, b) => a.t - b.t || rank[a.origin] - rank[b.origin])) {
    const other = kept.find(e => e.device && e.device === event.device && Math.abs(e.t - event.t) < 0.05);
    if (!other) kept.push(event); else if (event.kind === 'bad') other.kind = 'bad';
  }
  return kept;
}

/** Events in the order of time: [{t, text, kind, device, origin}]. */
function storyEvents() {
  const events = [];
  for (const knock of data.true_moves ?? []) {
    events.push({t: knock.t, kind: 'warn', text: `Truth: the camera ${knock.device} is moved by ${movedText(knock.moved)} ` +
      '(infuse does not know this).'});
  }
  for (const camera of data.cameras) {
    for (const span of stateSpans(camera.points, 'state').filter(s => s.name === 'RECALIBRATING')) {
      events.push({t: span.from, kind: 'warn', device: camera.device, origin: 'change', text: `${camera.device}: re-estimation starts in the background`});
    }
    for (const change of camera.history) {
      const moved = change.moved.rotation_deg > 1e-6 || change.moved.translation_cm > 1e-6
        ? `; the calibration in use moves by ${movedText(change.moved)}` : '';
      events.push({t: change.t, kind: change.state === 'OK' ? 'good' : 'warn', device: camera.device, origin: 'change',
        text: `${camera.device}: ${change.what}${moved}`});
    }
  }
  for (const alert of data.alerts) {
    const raised = alert.state === 'raised';
    events.push({t: alert.t, kind: !raised ? 'good' : alert.severity !== 'WARN' ? 'bad' : 'warn', device: alert.device,
      origin: raised ? 'raised' : 'cleared', text: raised ? `${alert.device}: ${alert.what}` : `${alert.device}: no longer: ${alert.what.split(':')[0]}`});
  }
  for (const state of data.map.states) {
    events.push({t: state.t, kind: state.state === 'TRACKING' ? 'good' : 'warn', text: `Street map: ${state.state}`});
  }
  return oneOfEach(events);
}

/** The error of a calibration along the axis with the most evidence: "+0.50 ± 0.10° about y". */
function errorText(point) {
  const axis = axisNames.indexOf(point.axis);
  if (!point.offset || axis < 0 || !(point.sigma[axis] < 1e3)) return '';
  const [factor, digits, unit] = axis < 3 ? [180 / Math.PI, 2, '°'] : [100, 1, ' cm'];
  return `${point.offset[axis] < 0 ? '−' : '+'}${(Math.abs(point.offset[axis]) * factor).toFixed(digits)} ± ${(point.sigma[axis] * factor).toFixed(digits)}${unit} ${axis < 3 ? 'about' : 'along'} ${'xyz'[axis % 3]}`;
}

/** One sentence about a camera: [class, text]. */
function cameraVerdict(camera) {
  const name = `The calibration of camera ${camera.device}`, end = last(camera.points);
  const wrong = camera.points.filter(p => ['CONFIRMED', 'RECALIBRATING'].includes(p.state));
  // The error as the report states it that is most certain of it.
  const sigma = p => p.sigma?.[axisNames.indexOf(p.axis)] ?? Infinity;
  const first = wrong[0], by = first ? errorText(wrong.reduce((a, b) => sigma(b) < sigma(a) ? b : a)) : '';
  const became = first ? `was found to be wrong${by ? ` by ${by}` : ''} at ${timeText(first.t)}` : '';
  const applied = camera.history.find(c => c.state === 'RECALIBRATED' && (!first || c.t >= first.t));
  const replaced = applied ? `; infuse replaced it at ${timeText(applied.t)}` : '';
  switch (end?.state) {
    case 'OK': return first ? ['good', `${name} ${became}${replaced}, and it is right at the end.`] : ['good', `${name} was right throughout.`];
    case 'SUSPECTED': return ['warn', `${name} is perhaps wrong${errorText(end) ? ` by ${errorText(end)}` : ''}: drive on for certainty.`];
    case 'RECALIBRATED': return ['warn', `${name} ${became}${replaced}; the new one is still on probation at the end.`];
    case 'CONFIRMED': case 'RECALIBRATING': return ['bad', `${name} ${became}, and it is still wrong at the end: recalibrate it (infuse calibrate).`];
    case 'UNUSABLE': return ['bad', `${name} could not be monitored.`];
    default: return ['idle', `${name} could not be judged: the drive has too few images.`];
  }
}

/** One sentence about the position: [class, text]. */
function positionVerdict() {
  const truth = errors => errors?.m.length ? `; against the truth rms ${rms(errors.m).toFixed(2)} m, maximum ${Math.max(...errors.m).toFixed(2)} m` : '';
  if (data.map.states.length === 0) {
    if (data.odom.x.length < 2) return ['idle', 'The position is not known: there is neither odometry nor a street map.'];
    return ['idle', `The position is known by odometry only; there is no street map${truth(data.odom_errors)}.`];
  }
  const spans = stateSpans(data.map.states, 'state'), tracked = spans.filter(s => s.name === 'TRACKING').reduce((sum, s) => sum + s.to - s.from, 0);
  const begun = spans.find(s => s.name === 'TRACKING'), sigma = Math.sqrt(Math.max(last(data.map.xx), last(data.map.yy)));
  if (!begun) return ['bad', 'The vehicle was not found on the street map.'];
  return [last(spans).name === 'TRACKING' ? 'good' : 'warn', `The vehicle was located on the street map at ${timeText(begun.from)} and tracked for ` +
    `${(100 * tracked / Math.max(1e-9, data.duration - begun.from)).toFixed(0)} % of the time since; standard deviation ${sigma.toFixed(1)} m at the end${truth(data.map_errors)}.`];
}

/** One sentence about the sensors: [class, text]. */
function sensorVerdict() {
  const sensors = [...data.health?.sensors ?? [], ...data.health?.streams ?? []];
  if (sensors.length === 0) return null;
  const names = new Set(sensors.map(s => s.device)), cameras = new Set(data.cameras.map(c => c.device));
  const calibration = /drift|calibration|re-estimation/i;  // a camera's name stands for its calibration, too
  const faults = data.alerts.filter(a => a.state === 'raised' && names.has(a.device) && !(cameras.has(a.device) && calibration.test(a.what)));
  const worst = faults.some(a => a.severity !== 'WARN') ? 'bad' : 'warn';
  if (faults.length === 0) return ['good', `All ${sensors.length} sensors delivered throughout: ${[...names].join(', ')}.`];
  return [worst, `${faults.length === 1 ? 'One fault' : `${faults.length} faults`} of sensors: ${faults.slice(0, 3).map(a => `${a.device} from ${timeText(a.since ?? a.t)}, ${a.what}`).join('; ')}${faults.length > 3 ? '; more below' : ''}.`];
}

const signs = {good: '✓', warn: '!', bad: '✕', idle: '–'};

function showHead() {
  place('title').textContent = data.name;
  document.title = `infuse: ${data.name}`;
  const devices = (Array.isArray(data.devices) ? data.devices : []).map(d => `${d.device} (${d.model || d.kind})`).join(', ');
  const facts = [['Recorded', `${utc(0)} to ${utc(data.duration).slice(11)} UTC, ${data.duration.toFixed(1)} s`], ['Sensors', devices],
    ['Configuration', data.configuration || 'defaults'], ['Made by', `infuse ${data.version ?? ''}, from ${data.reports} reports`]];
  place('facts').append(...facts.filter(f => f[1]).flatMap(([name, text]) => [element('dt', {}, name), element('dd', {}, text)]));
  for (const verdict of [...data.cameras.map(cameraVerdict), positionVerdict(), sensorVerdict()].filter(Boolean)) {
    place('verdicts').append(element('li', {class: verdict[0]}, element('b', {}, signs[verdict[0]]), ' ', element('span', {}, verdict[1])));
  }
  const events = storyEvents();
  const shown = events.slice(0, 60);
  for (const event of shown) {
    place('story').append(element('li', {}, element('time', {}, timeText(event.t)), element('span', {class: event.kind}, event.text)));
  }
  if (events.length > shown.length) place('story').append(element('li', {}, element('time'), `and ${events.length - shown.length} more`));
  if (events.length === 0) place('story').append(element('li', {}, element('time'), 'No alert and no change of a calibration.'));
}

function showPath() {
  const onMap = data.map.x.length > 1, truth = data.truth ?? null;
  const odom = data.odom_on_truth?.x.length ? data.odom_on_truth : onMap ? null : data.odom;
  const paths = [], names = [];
  const add = (path, colour, width, name) => {
    if (!path || path.x.length < 2) return;
    paths.push({x: path.x, y: path.y, colour, width});
    names.push([colour, name]);
  };
  add(truth, data.map_image ? '#111' : 'var(--truth)', 6, 'true path');
  add(odom, data.map_image ? '#56b4e9' : 'var(--odom)', 2.5, truth ? 'odometry, from the true first pose' : 'odometry');
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
    texts.push(`${name}: rms ${rms(errors.m).toFixed(2)} m, maximum ${Math.max(...errors.m).toFixed(2)} m` +
      (errors.horizontal_m ? ` (horizontally rms ${rms(errors.horizontal_m).toFixed(2)} m)` : ''));
  };
  addErrors(data.odom_errors, 'var(--odom)', 'odometry, from the true first pose');
  addErrors(onMap ? data.map_errors : null, 'var(--map)', 'on the street map');
  place('path-note').textContent = texts.length ? `Distance from the true position in three dimensions, as infuse evaluate has it: ${texts.join('; ')}.`
    : 'There is no truth to compare with.';
  place('path-map').append(planChart({paths, ellipses, image: data.map_image}), legend(names));
  if (lines.length === 0) return;
  place('path-errors').append(timeChart({title: 'Distance from the true position', unit: 'm', duration: data.duration, lines,
    zero: true, spans: onMap ? stateSpans(data.map.states, 'state') : []}),
  legend(lines.map((l, i) => [l.colour, texts[i].split(':')[0]])));
}

/** The colours of distance on the images: viridis, logarithmic from 80 m to 2 m (daemon/drawing/colour_scale.cpp). */
function rangeLegend() {
  const bar = element('span', {class: 'scale-bar'});
  for (const metres of [80, 50, 20, 10, 5, 2]) {
    const number = element('span', {}, String(metres));
    number.style.left = `${100 * (1 - Math.log(metres / 2) / Math.log(40))}%`;
    bar.append(number);
  }
  return element('p', {class: 'scale-legend'}, 'distance from the lidar, m', bar);
}

function overlayFigure(image) {
  const box = element('div', {class: 'compare'}, element('img', {src: image.before, alt: 'lidar over image, before'}));
  const figure = element('figure', {}, box);
  const at = `${image.device}, ${timeText(image.t)}`;
  if (!image.after) {
    figure.append(element('figcaption', {}, `${at}, with the calibration in use`));
    return figure;
  }
  const after = element('img', {src: image.after, class: 'after', alt: 'lidar over image, after'});
  const slider = element('input', {type: 'range', min: 0, max: 100, value: 50, 'aria-label': 'before and after'});
  const blink = element('button', {title: 'before and after in turn'}, 'Blink');
  let turn = 0;
  blink.addEventListener('click', () => {
    clearInterval(turn);
    turn = turn ? 0 : setInterval(() => { slider.value = Number(slider.value) < 50 ? 100 : 0; cut(); }, 700);
    blink.textContent = turn ? 'Stop' : 'Blink';
  });
  const cut = () => { after.style.clipPath = `inset(0 0 0 ${slider.value}%)`; };
  slider.addEventListener('input', cut);
  cut();
  box.append(after);
  figure.append(element('div', {class: 'tools'}, slider, blink), element('figcaption', {}, `${at}. Left of the slider: the calibration at the start; right: the one ` +
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
  const [kind, sentence] = cameraVerdict(camera);
  const parts = [element('h3', {}, `Camera ${camera.device}`), element('p', {class: kind}, `${signs[kind]} ${sentence}`)];
  if (evidence.length) {
    parts.push(element('p', {class: 'note'}, 'Evidence that the camera has moved against the lidar, along the axis with the ' +
      'most. Above the threshold (dashed) the drift is confirmed. A point is a report; hold the pointer over it for its axis.'),
      timeChart({title: 'Evidence for a drift', unit: 'nats', duration: data.duration, zero: true,
        spans: stateSpans(camera.points, 'state'), marks,
        lines: [{points: evidence.map(p => [p.t, p.nats, `${p.axis}: ${p.nats} nats`]), colour: 'var(--odom)', dots: true},
          {points: evidence.map(p => [p.t, p.threshold_nats]).concat([[data.duration, last(evidence).threshold_nats]]),
            colour: 'var(--bad)', dash: true, label: `confirmed above ${last(evidence).threshold_nats.toFixed(1)} nats`}]}));
  }
  const images = (data.overlays ?? []).filter(p => p.device === camera.device);
  if (images.length) {
    parts.push(element('h3', {}, 'Lidar over the image'), element('p', {class: 'note'},
      'Where the colour of the returns jumps from near to far, the image should have an edge. Move the slider, or let it blink.'),
      rangeLegend(), ...images.map(overlayFigure));
  }
  if (evidence.length > 1) {
    parts.push(element('h3', {}, 'Estimated error of the calibration in use, per axis'),
      element('p', {class: 'note'}, 'With two standard deviations. Axes of the camera: x right, y down, z ahead.'),
      element('div', {class: 'row'}, ...axisNames.map((_, axis) => offsetChart(camera, axis))));
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
    place('sources').append(table(['source', 'used', 'accepted', 'rejected'],
      odometry.sources.map(s => [s.name, s.carries ? 'yes' : 'no', s.accepted ?? '', s.rejected ?? ''])));
  }
}

function showHealth() {
  const spans = stateSpans(data.levels, 'level');
  place('levels').append(element('p', {class: 'note'}, `Level: ${spans.slice(0, 20).map(s =>
    `${s.name} from ${timeText(s.from)}`).join(', ') || 'not reported'}.`));
  place('alerts').append(data.alerts.length === 0 ? element('p', {}, 'No alert.') : table(
    ['since', 'until', 'severity', 'device', 'what', 'what to do'],
    data.alerts.filter(a => a.state === 'raised').map(a => {
      const end = data.alerts.find(b => b.state !== 'raised' && b.id === a.id && b.t >= a.t);
      return [timeText(a.since ?? a.t), end ? timeText(end.t) : 'still raised', a.severity, a.device, a.what, a.advice];
    })));
  const sensors = data.health?.sensors ?? [], streams = data.health?.streams ?? [];
  const lost = s => Object.entries(s.losses ?? {}).filter(e => e[1] > 0).map(e => `${e[0]} ${e[1]}`).join(', ') || 'none';
  place('sensors').append(element('h3', {}, 'Sensors at the end'), table(['device', 'kind', 'level', 'rate', 'used', 'lost'],
    sensors.map(s => [s.device, 'lidar', s.level, `${s.sweeps_hz?.toFixed(1)} sweeps/s`, `${s.sweeps} sweeps`, lost(s)]).concat(
      streams.map(s => [s.device, s.kind, s.level, `${s.received_hz?.toFixed(1)} /s`, `${s.used} of ${s.received}`,
        s.lost > 0 ? String(s.lost) : 'none']))));
}

/** Around the seam, 15 m from the lidar in the direction in which the sweep begins and ends: as measured, and deskewed. */
function showSweep({url, seam, metres, stamp_ns}) {
  const t = Number(BigInt(stamp_ns) - BigInt(data.begin_ns)) / 1e9, half = 16, distance = 15;
  place('sweep-note').textContent = `The sweep at ${timeText(t)}, from above, ${2 * half} m wide, around the direction in which it begins and ends. ` +
    'Blue is the beginning of the turn, yellow its end, a turn later: a straight wall must go on straight from one to the other.';
  const image = new Image();
  image.onload = () => {
    const view = (image.width - 8) / 2, scale = view / (2 * metres);
    const u = view / 2 - distance * Math.sin(seam) * scale, v = view / 2 - distance * Math.cos(seam) * scale;
    ['as measured', 'deskewed'].forEach((name, i) => {
      const canvas = element('canvas', {width: 520, height: 520, role: 'img', 'aria-label': `sweep from above, ${name}`}), context = canvas.getContext('2d');
      const left = Math.min(view - 2 * half * scale, Math.max(0, u - half * scale)), top = Math.min(view - 2 * half * scale, Math.max(0, v - half * scale));
      context.imageSmoothingEnabled = false;
      context.fillRect(0, 0, 520, 520);
      context.drawImage(image, i * (view + 8) + left, top, 2 * half * scale, 2 * half * scale, 0, 0, 520, 520);
      context.fillStyle = context.strokeStyle = '#fff';
      context.font = '14px system-ui, sans-serif';
      const bar = 5 / (2 * half) * 520;
      context.fillRect(16, 500, bar, 3);
      context.fillText('5 m', 16, 494);
      place('sweep-image').append(element('figure', {}, canvas, element('figcaption', {}, name)));
    });
  };
  image.src = url;
}

showHead();
showPath();
if (data.cameras.length) data.cameras.forEach(showCamera); else remove('calibration');
showOdometry();
if (data.sweep) showSweep(data.sweep); else remove('sweep');
showHealth();
place('notes').textContent = [...(data.notes ?? []),
  data.left_out ? `${data.left_out} reports are beyond what is drawn.` : '',
  data.unreadable ? `${data.unreadable} lines of the reports file are damaged.` : ''].filter(Boolean).join(' ');

'use strict';
// The page: messages of the daemon into panels.

const place = id => document.getElementById(id);
const seconds = ns => Number(ns) / 1e9;
const levelClass = {OK: 'good', WARN: 'warn', ERROR: 'bad', STALE: 'bad', TRACKING: 'good', UNSURE: 'warn', LOST: 'bad',
  MONITORING: 'good', SUSPECTED: 'warn', CONFIRMED: 'bad', RECALIBRATED: 'warn', RECALIBRATING: 'warn', UNUSABLE: 'bad'};
const historySeconds = 600;

const scene = new Scene(place('points'));
const overlays = new Map(), calibrations = new Map(), alerts = new Map();
let socket = null;
let health = null, mapPose = null, start = null, panel = 'scene', slow = 0;
let shownAt = Infinity;  // drive time that is shown, s

/** A binary message: header, points and the rest of it. */
function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const n = header.points;
  let at = 4 + length;
  const take = (Type, bytes) => { const out = new Type(buffer, at, n); at += n * bytes; return out; };
  const points = {x: take(Int16Array, 2), y: take(Int16Array, 2), z: take(Int16Array, 2),
    reflectivity: take(Uint8Array, 1), ring: take(Uint8Array, 1)};
  return {header, points, rest: new Uint8Array(buffer, at)};
}

function driveTime(stamp) {
  const now = seconds(stamp);
  if (start === null || now < start) start = now;
  return now - start;
}

const state = (name, text) => element('span', {class: levelClass[name] ?? ''}, text ?? name);
const fixed = (value, digits) => typeof value === 'number' ? value.toFixed(digits) : '';

function addCalibration(report) {
  const known = calibrations.get(report.device) ?? {points: []};
  known.points.push({t: driveTime(report.stamp), nats: report.evidence?.nats ?? 0, threshold: report.evidence?.threshold_nats,
    state: report.state});
  const newest = known.points[known.points.length - 1].t;
  while (known.points[0].t < newest - historySeconds) known.points.shift();
  calibrations.set(report.device, known);
}

function showCalibration(report) {
  calibrations.get(report.device).report = report;
  const overlay = overlays.get(report.device);
  if (overlay) overlay.estimate = report.estimate?.T_camera_lidar;
  if (panel === 'calibration') showCalibrations();
}

/** Of the rotations and the translations of a covariance, row by row. */
function estimateSigma(covariance) {
  const sigma = i => Math.sqrt(Math.max(0, covariance[7 * i]));
  return `${[0, 1, 2].map(i => fixed(sigma(i) * 180 / Math.PI, 3)).join(', ')} ° and ${[3, 4, 5].map(i => fixed(100 * sigma(i), 1)).join(', ')} cm`;
}

function showCalibrations() {
  const parts = [];
  for (const [device, {report, points: all}] of calibrations) {
    const points = all.filter(p => p.t <= shownAt - (start ?? 0));
    if (!report || points.length === 0) continue;
    parts.push(element('h2', {}, `${device}: `, state(report.state), report.frozen ? ' (frozen)' : ''));
    if (report.evidence) parts.push(element('p', {class: 'dim'}, `strongest: ${report.evidence.axis}; policy ${report.policy}`));
    const from = points[0].t, duration = Math.max(10, points[points.length - 1].t - from);
    parts.push(timeChart({title: 'Evidence for a drift', unit: 'nats', duration, zero: true, height: 200, lines: [
      {points: points.map(p => [p.t - from, p.nats]), colour: 'var(--odom)', step: true},
      {points: points.filter(p => p.threshold !== undefined).map(p => [p.t - from, p.threshold]), colour: 'var(--bad)', dash: true}]}));
    if (report.offset) {
      const axes = ['rotation x', 'rotation y', 'rotation z', 'translation x', 'translation y', 'translation z'];
      const scale = i => i < 3 ? 180 / Math.PI : 100;
      parts.push(table(['offset along', 'estimate', '±', ''], axes.map((axis, i) => [axis,
        fixed(report.offset[i] * scale(i), i < 3 ? 3 : 1), fixed(report.offset_sigma[i] * scale(i), i < 3 ? 3 : 1), i < 3 ? '°' : 'cm'])));
    }
    if (report.estimate) {
      parts.push(element('p', {}, `Last estimate: ${report.estimate.scenes} scenes, `,
        state(report.estimate.usable ? 'OK' : 'WARN', report.estimate.usable ? 'usable' : report.estimate.reason),
        `; standard deviation ${estimateSigma(report.estimate.covariance)}`));
    }
    if (report.history?.length) {
      parts.push(table(['at', 'state', 'what'], report.history.map(h => [`${driveTime(h.stamp).toFixed(1)} s`, h.state, h.what])));
    }
  }
  place('calibration').replaceChildren(...(parts.length ? parts : [element('p', {class: 'dim'}, 'No calibration is monitored yet.')]));
}

function showMotion() {
  const parts = [], odometry = health?.odometry, map = health?.streetmap;
  if (odometry) {
    parts.push(element('h2', {}, 'Odometry: ', state(odometry.level, odometry.usable ? 'usable' : odometry.reason)),
      table(['', 'value', '±'], [
        ['speed, m/s', fixed(odometry.speed, 2), fixed(odometry.speed_sigma, 3)],
        ['yaw rate, °/s', fixed(odometry.yaw_rate * 180 / Math.PI, 2), fixed(odometry.yaw_rate_sigma * 180 / Math.PI, 3)],
        ['scale of the wheels', fixed(odometry.wheel_scale, 4), fixed(odometry.wheel_scale_sigma, 4)],
        ['bias of the gyro, °/s', fixed(odometry.gyro_bias * 180 / Math.PI, 3), fixed(odometry.gyro_bias_sigma * 180 / Math.PI, 3)]]),
      table(['source', 'carries it', 'accepted', 'rejected'],
        odometry.sources.map(s => [s.name, s.carries ? 'yes' : '', s.accepted, s.rejected])));
  }
  if (map) {
    parts.push(element('h2', {}, 'Street map: ', state(map.state)), element('p', {}, map.reason ?? ''),
      table(['', ''], [['standard deviation, m', fixed(map.sigma, 2)], ['likely elsewhere', fixed(map.elsewhere, 3)],
        ['particles', map.particles], ['hypotheses', map.hypotheses ?? ''], ['updates', map.updates]]));
  }
  if (mapPose) parts.push(element('p', {class: 'dim'}, `on the map: x ${fixed(mapPose.T_frame_vehicle[3], 1)}, y ${fixed(mapPose.T_frame_vehicle[7], 1)} m`));
  place('motion').replaceChildren(...(parts.length ? parts : [element('p', {class: 'dim'}, 'No odometry.')]));
}

function showHealth() {
  if (!health) return place('health').replaceChildren();
  const ms = s => s.latency_ms ? [fixed(s.latency_ms.p50, 1), fixed(s.latency_ms.p99, 1), fixed(s.latency_ms.max, 1)] : ['', '', ''];
  const lost = s => Object.values(s.losses ?? {}).reduce((sum, v) => sum + (typeof v === 'number' ? v : 0), 0);
  const parts = [element('h2', {}, 'Lidars'),
    table(['device', 'level', 'sweeps/s', 'packets/s', 'lost', 'clock'], (health.sensors ?? []).map(s => [s.device, state(s.level),
      fixed(s.sweeps_hz, 1), fixed(s.packets_hz, 0), lost(s), s.clock ? `${s.clock.source}${s.clock.trusted ? '' : ': ' + (s.clock.reason ?? 'not trusted')}` : ''])),
    element('h2', {}, 'Other devices'),
    table(['device', 'kind', 'level', 'received/s', 'used', 'lost'], (health.streams ?? []).map(s => [s.device, s.kind, state(s.level),
      fixed(s.received_hz, 1), s.used, s.lost]))];
  if (health.host) {
    parts.push(element('h2', {}, 'Stages'), table(['stage', 'median, ms', '99 %', 'largest', 'runs', 'over the budget'],
      health.host.stages.map(s => [s.stage, ...ms(s), s.latency_ms ? s.count : s.count, s.deadline_misses ?? ''])),
      element('h2', {}, 'Queues'), table(['queue', 'depth', 'capacity', 'lost'],
        health.host.queues.map(q => [q.queue, q.depth, q.capacity, q.lost])));
  }
  place('health').replaceChildren(...parts);
}

function showAlerts() {
  place('alerts').replaceChildren(...[...alerts.values()].map(a => element('p', {class: a.severity === 'WARN' ? 'warn' : 'bad'},
    `${a.device}: ${a.what}`, element('span', {class: 'dim'}, ` since ${driveTime(a.since ?? a.stamp).toFixed(0)} s${a.advice ? '; ' + a.advice : ''}`))));
}

const panels = {scene: () => scene.draw(), cameras: () => overlays.forEach(overlay => overlay.show()), calibration: showCalibrations, motion: showMotion, health: showHealth};

function open(name) {
  panel = name;
  for (const section of document.querySelectorAll('section')) section.hidden = section.id !== name;
  for (const button of document.querySelectorAll('nav button')) button.setAttribute('aria-current', String(button.dataset.panel === name));
  panels[name]();
  askForProfiles();
}

/** Profiles are made only while a page shows them. */
function askForProfiles() {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({profiles: panel === 'cameras'}));
}

/** What each key of the history shows. */
const show = {
  CALIBRATION: showCalibration,
  POSE: message => { mapPose = message; if (panel === 'motion') showMotion(); },
  HEALTH(message) {
    health = message;
    place('time').textContent = `${driveTime(message.stamp).toFixed(0)} s`;
    place('level').replaceChildren(state(message.level ?? 'OK'));
    if (panel === 'motion' || panel === 'health') panels[panel]();
  },
  ALERTS(list) {
    alerts.clear();
    for (const alert of list) alerts.set(alert.id, alert);
    showAlerts();
  },
  map(frame) { scene.map = frame; },
  sweep(frame) {
    scene.frame = frame;
    if (panel === 'scene') scene.request();
    place('sweep').textContent = `${frame.header.device}: ${frame.header.points} returns shown, ` +
      (frame.header.deskewed ? 'deskewed' : 'as measured');
  },
  image(frame) {
    const device = frame.header.device;
    if (!overlays.has(device)) {
      overlays.set(device, new Overlay(place('cameras'), device));
      overlays.get(device).estimate = calibrations.get(device)?.report?.estimate?.T_camera_lidar;
    }
    overlays.get(device).latest = frame;
    scene.colours?.add(frame);
    if (panel === 'cameras') overlays.get(device).show();
  },
  profile(frame) { overlays.get(frame.header.device)?.showProfile(frame); },
};
/** What is shown of a key at a time before its first value. */
const clear = {
  CALIBRATION(device) {
    calibrations.get(device).report = undefined;
    if (panel === 'calibration') showCalibrations();
  },
  POSE: () => { mapPose = null; },
  HEALTH() {
    health = null;
    place('time').textContent = '';
    place('level').replaceChildren();
    if (panel === 'motion' || panel === 'health') panels[panel]();
  },
  ALERTS: () => show.ALERTS([]),
  profile(device) { overlays.get(device)?.showProfile(null); },
};
const showKey = (key, value) => {
  const [kind, ...device] = key.split(':');
  if (value !== null) show[kind](value); else clear[kind]?.(device.join(':'));
};

const player = new Player(showKey, command => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(command));
});

/** Messages of the daemon: kept, and shown unless somebody looks back. */
const receive = {
  VIEW(message) {
    start = null;
    calibrations.clear();
    raised.clear();
    scene.track = [];
    player.begin(message.replay);
    askForProfiles();
  },
  LOST(message) {
    place('connection').textContent = `connected; this page is slow: ${message.count} messages left out`;
    clearTimeout(slow);
    slow = setTimeout(() => { if (socket.readyState === WebSocket.OPEN) place('connection').textContent = 'connected'; }, 5000);
  },
  CALIBRATION(message, bytes) {
    addCalibration(message);
    player.add(`CALIBRATION:${message.device}`, seconds(message.stamp), message, bytes);
  },
  POSE: (message, bytes) => { if (message.frame === 'map') player.add('POSE', seconds(message.stamp), message, bytes); },
  HEALTH: (message, bytes) => { driveTime(message.stamp); player.add('HEALTH', seconds(message.stamp), message, bytes); },
  ALERT(message, bytes) {
    const wasRaised = message.state === 'raised';
    if (wasRaised) raised.set(message.id, message); else raised.delete(message.id);
    player.add('ALERTS', seconds(message.stamp), [...raised.values()], bytes);
    if (wasRaised) player.addAlert(seconds(message.stamp), `${driveTime(message.stamp).toFixed(0)} s ${message.device}: ${message.what}`);
  },
};
const raised = new Map();  // alerts, by id

function receiveFrame(frame, bytes) {
  const {kind, device, stamp} = frame.header;
  driveTime(stamp);
  if (kind === 'sweep') scene.addTrack(frame);
  if (kind === 'map') player.add('map', seconds(stamp), frame, bytes);
  if (kind === 'sweep' || kind === 'image' || kind === 'profile') player.add(`${kind}:${device}`, seconds(stamp), frame, bytes);
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/stream`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { place('connection').textContent = 'connected'; };
  socket.onmessage = event => {
    if (typeof event.data !== 'string') return receiveFrame(decode(event.data), event.data.byteLength);
    const message = JSON.parse(event.data);
    receive[message.class]?.(message, 4 * event.data.length);
  };
  socket.onclose = () => {
    place('connection').textContent = 'the daemon has ended or cannot be reached; trying again';
    setTimeout(connect, 1000);
  };
}

for (const button of document.querySelectorAll('nav button')) button.addEventListener('click', () => open(button.dataset.panel));
place('colour').addEventListener('change', e => scene.setColour(Number(e.target.value)));
place('camera').addEventListener('change', e => scene.look(e.target.value));
document.addEventListener('keydown', e => {
  const names = Object.keys(panels);
  if (e.target instanceof HTMLInputElement || e.target instanceof HTMLSelectElement) return;
  const button = {' ': 'pause', ArrowLeft: 'back', ArrowRight: 'step', End: 'newest'}[e.key];
  if (button) { e.preventDefault(); place(button).click(); }
  if (e.key >= '1' && e.key <= String(names.length)) open(names[Number(e.key) - 1]);
});
const asked = location.hash.slice(1);
open(panels[asked] ? asked : 'scene');
connect();

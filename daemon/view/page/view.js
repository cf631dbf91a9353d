'use strict';
// The page: messages of the daemon into panels.

const place = id => document.getElementById(id);
const seconds = ns => Number(ns) / 1e9;

let socket = null, slow = 0;
let health = null, shownAlerts = [];
let driveStart = null;   // s; where drive time begins
let shownAt = Infinity;  // time that is shown, s

/** Drive time: "15.6 s". */
const timeText = t => `${(t - (driveStart ?? t)).toFixed(1)} s`;
/** "12:26:40 UTC", if the stamps are of a clock that knows the date. */
const utcText = t => t > 946684800 ? `${new Date(1000 * t).toISOString().slice(0, 19).replace('T', ' ')} UTC` : '';

const course = new Course();
const scene = new Scene(place('points'));
const plan = new Plan(place('plan-canvas'));
const calibrationPanel = new CalibrationPanel(place('calibrations'), course);
const overlays = new Map();
const timeline = new Timeline(place('timeline'), course, t => player.hold(t));

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

/** What is drawn anew, once before the screen is next refreshed. */
const due = new Set();
function redraw(...names) {
  if (due.size === 0) requestAnimationFrame(() => {
    const now = [...due];
    due.clear();
    for (const name of now) if (drawing[name]) drawing[name]();
  });
  names.forEach(name => due.add(name));
}
const ifSeen = (panel, draw) => () => { if (layout.seen(panel)) draw(); };
const drawing = {
  scene: ifSeen('scene', () => scene.draw()),
  cameras: ifSeen('cameras', () => {
    if (overlays.size === 0) place('images').replaceChildren(noCamera()); else overlays.forEach(overlay => overlay.show());
  }),
  calibration: ifSeen('calibration', () => calibrationPanel.show(driveStart ?? 0, player.history.newest ?? 0, shownTime())),
  plan: ifSeen('plan', () => {
    plan.now = shownAt;
    plan.draw();
    place('plan-empty').replaceChildren(...(plan.track.length === 0 ? [emptyState('No place and no odometry.', 'Add wheel speeds, an inertial unit or GNSS ' +
      '(drive.toml or [vehicle] of infused(8)), or a second sweep for the lidar\'s own odometry.')] : plan.onMap() ? [] : [emptyState('No street map.',
      'infuse streetmap FILE.osm -o town.map makes one; name it in the configuration: [streetmap] map = "town.map".')]));
  }),
  health: ifSeen('health', () => place('health-body').replaceChildren(...(health ? healthTables(health) : [emptyState('No report yet.', 'HEALTH comes every second.')]))),
  head: showHead,
};
const noCamera = () => emptyState('No image.', 'Add a camera: [[camera]] in drive.toml, or in the configuration of a live run (infused(8)); ' +
  'an image is shown once a sweep belongs to it.');
const shownTime = () => shownAt === Infinity ? player.history.newest ?? 0 : shownAt;
/** ", of 5.1 s" for a sweep or an image that is older than the time that is shown; nothing for a new one. */
const ageText = ({stamp}) => shownTime() - seconds(stamp) > 1.5 ? `, of ${timeText(seconds(stamp))}` : '';

function showHead() {
  const t = shownTime(), level = health?.level;
  place('level').replaceChildren(...(level ? [stateBadge(level)] : []));
  place('time').textContent = player.history.newest === null ? '' : `${timeText(t)}  ${utcText(t)}`;
  const calibrations = [...calibrationPanel.cameras.values()].map(c => c.report).filter(Boolean);
  plan.now = shownAt;
  showStrip(health, calibrations, plan.place(), plan.origin());
  showAlerts(shownAlerts, health);
  place('sweep').textContent = [...scene.frames.values()].map(({header}) => `${header.device}: ${header.points} returns shown, ` +
    (header.deskewed ? 'deskewed' : 'as measured') + ageText(header)).join('; ');
  overlays.forEach(overlay => overlay.showNote());
}

const layout = new Layout(() => {
  redraw('scene', 'cameras', 'calibration', 'plan', 'health');
  askForProfiles();
});

/** Profiles are made only while a page shows them. */
function askForProfiles() {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({profiles: layout.seen('calibration')}));
}

/** What each key of the history shows. */
const show = {
  CALIBRATION(report) {
    calibrationPanel.camera(report.device).report = report;
    overlays.get(report.device)?.calibrated(report);
    redraw('calibration', 'head');
  },
  HEALTH(message) {
    health = message;
    redraw('head', 'health', 'calibration');
  },
  ALERTS(list) {
    shownAlerts = list;
    redraw('head');
  },
  map(frame) { scene.map = frame; redraw('plan'); },
  sweep(frame) {
    scene.frames.set(frame.header.device, frame);
    scene.frame = frame;
    redraw('scene', 'plan', 'head');
  },
  image(frame) {
    const device = frame.header.device;
    if (!overlays.has(device)) {
      if (overlays.size === 0) place('images').replaceChildren();
      overlays.set(device, new Overlay(place('images'), device));
      overlays.get(device).calibrated(calibrationPanel.cameras.get(device)?.report);
    }
    overlays.get(device).latest = frame;
    scene.colours?.add(frame);
    redraw('cameras');
  },
  profile(frame) {
    calibrationPanel.camera(frame.header.device).profile = frame;
    redraw('calibration');
  },
};
/** What is shown of a key at a time before its first value. */
const clear = {
  CALIBRATION(device) {
    calibrationPanel.camera(device).report = undefined;
    overlays.get(device)?.calibrated(undefined);
    redraw('calibration', 'head');
  },
  HEALTH() { health = null; redraw('head', 'health'); },
  ALERTS: () => show.ALERTS([]),
  profile(device) { calibrationPanel.camera(device).profile = null; redraw('calibration'); },
};
const showKey = (key, value) => {
  const [kind, ...device] = key.split(':');
  if (value !== null) show[kind](value); else clear[kind]?.(device.join(':'));
};

const player = new Player(showKey, command => {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(command));
}, () => redraw('head', 'calibration', 'plan'));
scene.past = (device, t, count) => {
  const list = player.history.entries.get(`sweep:${device}`) ?? [], i = DriveHistory.indexAt(list, t + 1e-6);
  return list.slice(Math.max(0, i + 1 - count), i + 1).map(entry => entry.value);
};

const raised = new Map();  // alerts, by id
/** Messages of the daemon: kept, and shown unless somebody looks back. */
const receive = {
  VIEW(message) {
    driveStart = null;
    raised.clear();
    course.clear();
    calibrationPanel.clear();
    health = null;
    shownAlerts = [];
    scene.track = [];
    scene.frames.clear();
    overlays.clear();
    place('images').replaceChildren();
    [plan.track, plan.parts] = [[], []];
    place('camera-legend').replaceChildren(scaleLegend(quantities.range));
    player.begin(message.replay);
    askForProfiles();
  },
  END() {
    player.end();
    place('connection').textContent = 'connected; the drive has ended';
  },
  LOST(message) {
    place('connection').textContent = `connected; this page is slow: ${message.count} messages left out`;
    clearTimeout(slow);
    slow = setTimeout(() => { if (socket.readyState === WebSocket.OPEN) place('connection').textContent = 'connected'; }, 5000);
  },
  CALIBRATION(message, bytes) {
    calibrationPanel.add(message);
    course.addState(message.device, seconds(message.stamp), message.state);
    player.add(`CALIBRATION:${message.device}`, seconds(message.stamp), message, bytes);
  },
  HEALTH(message, bytes) {
    const t = seconds(message.stamp);
    driveStart = t - message.drive_s;
    course.addState('health', t, message.level);
    if (message.streetmap) course.addState('street map', t, message.streetmap.state);
    if (message.map) course.addState('map', t, message.map.state);
    course.addSpeed(t, message.odometry?.speed);
    player.add('HEALTH', t, message, bytes);
  },
  ALERT(message, bytes) {
    const wasRaised = message.state === 'raised';
    if (wasRaised) raised.set(message.id, message); else raised.delete(message.id);
    course.addAlert(message);
    player.add('ALERTS', seconds(message.stamp), [...raised.values()], bytes);
    if (wasRaised) player.addAlert(seconds(message.stamp));
  },
};

function receiveFrame(frame, bytes) {
  const {kind, device} = frame.header, t = seconds(frame.header.stamp);
  driveStart ??= t;  // until HEALTH states it
  if (kind === 'sweep') { scene.addTrack(frame); plan.add(frame); }
  if (kind === 'map') { plan.addMap(frame); player.add('map', t, frame, bytes); }
  if (kind === 'sweep' || kind === 'image' || kind === 'profile') player.add(`${kind}:${device}`, t, frame, bytes);
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/stream`);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { place('connection').textContent = 'connected'; };
  socket.onmessage = event => {
    if (event.data instanceof ArrayBuffer) return receiveFrame(decode(event.data), event.data.byteLength);
    for (const line of event.data.split('\n')) {
      const message = JSON.parse(line);
      receive[message.class]?.(message, 4 * line.length);
    }
  };
  socket.onclose = () => {
    place('connection').textContent = 'the daemon has ended or cannot be reached; trying again';
    setTimeout(connect, 1000);
  };
}

/** A control: what it sets is remembered, and shown. */
function control(id, key, event, read, apply) {
  const input = place(id);
  if (input.type === 'checkbox') input.checked = remembered[key]; else input.value = remembered[key];
  const set = () => { remember({[key]: read(input)}); apply(remembered[key]); };
  input.addEventListener(event, set);
  apply(remembered[key]);
}
const sceneLegend = () => {
  const quantity = sceneQuantities[scene.colour], count = [...scene.frames.values()][0]?.points.ring.reduce((a, b) => Math.max(a, b), 0);
  place('scene-legend').replaceChildren(...(quantity ? [scaleLegend(quantity, quantity === quantities.ring ? v => `${Math.round(100 * v)} %` : String)]
    : ['colours of the camera images; grey: in no image']));
  return count;
};
control('colour', 'colour', 'change', e => Number(e.value), v => { scene.setColour(v); sceneLegend(); });
control('accumulate', 'accumulate', 'change', e => Number(e.value), v => { scene.accumulate = v; scene.draw(); });
control('size', 'size', 'input', e => Number(e.value), v => { scene.size = v; scene.draw(); overlays.forEach(o => o.draw()); });
control('opacity', 'opacity', 'input', e => Number(e.value), () => overlays.forEach(o => o.draw()));
control('arrows', 'arrows', 'change', e => e.checked, () => overlays.forEach(o => o.draw()));
place('camera').addEventListener('change', e => scene.look(e.target.value));
place('reset').addEventListener('click', () => { place('camera').value = 'follow'; scene.look('follow'); });
place('plan-reset').addEventListener('click', () => plan.reset());
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => layout.update());
new ResizeObserver(() => overlays.forEach(o => o.draw())).observe(place('images'));
document.addEventListener('keydown', e => {
  const names = layout.sections.map(s => s.id);
  if (e.target instanceof HTMLInputElement || e.target instanceof HTMLSelectElement) return;
  const button = {' ': 'pause', ArrowLeft: 'back', ArrowRight: 'step', End: 'newest'}[e.key];
  if (button) { e.preventDefault(); place(button).click(); }
  if (e.key === 'Escape') layout.enlarge('');
  if (e.key >= '1' && e.key <= String(names.length)) layout.open(names[Number(e.key) - 1]);
});
const asked = location.hash.slice(1);
if (layout.sections.some(s => s.id === asked)) layout.open(asked);
connect();

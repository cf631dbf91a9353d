'use strict';
// The strip of health: one chip for the calibration of each camera, the position, the odometry and each sensor; and the
// alerts. And the tables behind it.

const stateBadge = (name, text) => { const kind = levelClass[name] ?? 'idle'; return element('span', {class: kind}, `${marks[kind]} ${text ?? name}`); };
const fixed = (value, digits) => typeof value === 'number' ? value.toFixed(digits).replace('-', '−') : '';

/** A chip: [class, panel it opens, name, text]. */
function chip(kind, panel, name, text) {
  const made = element('button', {class: `chip ${kind}`, 'data-opens': panel}, element('span', {class: 'mark'}, marks[kind]), ' ',
    element('b', {}, name), ' ', element('span', {class: 'what'}, text));
  made.addEventListener('click', () => layout.open(panel));
  return made;
}

/** When a finding of a sensor or stage began: silence with its last data, everything else when it was raised. */
const beginOf = (finding, part) => (finding.id === 'silent' ? part?.last_packet ?? part?.last : undefined) ?? finding.since;

/** Of the findings of a sensor or stage: what is wrong, and since when. */
function findingText(part) {
  const finding = part.findings?.find(f => f.level === part.level) ?? part.findings?.[0];
  if (!finding) return '';
  const begin = beginOf(finding, part);
  return finding.what + (begin !== undefined ? `, since ${timeText(seconds(begin))}` : '');
}

function positionChip(health, at, origin) {
  const map = health.map ?? health.streetmap;
  if (!map && !at?.odom) return null;
  if (!map) return chip('idle', 'plan', 'position', `x ${fixed(at.odom[0], 1)} m, y ${fixed(at.odom[1], 1)} m from the start`);
  const pose = at?.map, degrees = pose && origin ? ` (${toDegrees(origin, pose[0], pose[1]).map(d => d.toFixed(5) + '°').join(' ')})` : '';
  const where = pose && map.state !== 'LOST' ? `, east ${fixed(pose[0], 1)} m, north ${fixed(pose[1], 1)} m ± ${fixed(map.sigma, 1)} m${degrees}` : '';
  return chip(levelClass[map.state] ?? levelClass[map.level] ?? 'idle', 'plan', 'position', map.state + where + (map.level !== 'OK' && findingText(map) ? `: ${findingText(map)}` : ''));
}

function sensorChip(part, rate, unit) {
  const kind = levelClass[part.level] ?? 'idle';
  return chip(kind, 'health', part.device, kind === 'good' ? `${fixed(rate, 1)} ${unit}` : findingText(part) || part.level);
}

/** The chips: `calibrations`: reports that are shown. */
function showStrip(health, calibrations, at, origin) {
  const chips = calibrations.map(report => { const [kind, text] = verdict(report, course); return chip(kind, 'calibration', report.device, text); });
  if (health) {
    const position = positionChip(health, at, origin), odometry = health.odometry;
    if (position) chips.push(position);
    if (odometry) {
      chips.push(chip(levelClass[odometry.level] ?? 'idle', 'health', 'odometry', odometry.usable
        ? `${fixed(odometry.speed, 1)} m/s` : `not usable: ${odometry.reason ?? 'unknown'}`));
    }
    for (const s of health.sensors ?? []) chips.push(sensorChip(s, s.sweeps_hz, 'sweeps/s'));
    for (const s of health.streams ?? []) chips.push(sensorChip(s, s.received_hz, s.kind === 'camera' ? 'images/s' : 'samples/s'));
  }
  // What needs somebody comes first: on a phone the strip shows two chips.
  const urgency = c => ['bad', 'warn'].indexOf(c.className.split(' ')[1]) >>> 0;
  place('strip').replaceChildren(...chips.sort((a, b) => urgency(a) - urgency(b)));
}

/** An alert as HEALTH has it now: {what, since}; the figures of a finding change while it is raised. */
function presentAlert(alert, health) {
  for (const part of [health, ...health?.sensors ?? [], ...health?.streams ?? [], ...health?.calibrations ?? [], health?.odometry, health?.streetmap, health?.map]) {
    const found = part?.findings?.find(f => alert.id === f.id || (alert.id.endsWith(`.${f.id}`) && alert.id.startsWith(`${part.device ?? ''}`)));
    if (found) return {what: found.what, since: beginOf(found, part)};
  }
  return {what: alert.what, since: alert.since ?? alert.stamp};
}

function showAlerts(alerts, health) {
  const line = (a, {what, since}) => element('p', {class: a.severity === 'WARN' ? 'warn' : 'bad', title: a.advice ?? ''},
    element('b', {}, `${a.severity === 'WARN' ? marks.warn : marks.bad} ${a.severity} `), `${a.device}: ${what}`,
    element('b', {}, `, since ${timeText(seconds(since))}`), element('span', {class: 'dim'}, a.advice ? ` – ${a.advice}` : ''));
  place('alerts').replaceChildren(...alerts.slice(0, 3).map(a => line(a, presentAlert(a, health))),
  ...(alerts.length > 3 ? [element('p', {class: 'dim'}, `and ${alerts.length - 3} more`)] : []));
}

const part = (title, ...content) => element('div', {}, element('h3', {}, ...[title].flat()), ...content);

function motionTables({odometry, streetmap}) {
  const parts = [], degrees = v => v === undefined ? undefined : v * 180 / Math.PI;
  if (odometry) {
    parts.push(part(['Odometry: ', stateBadge(odometry.level, odometry.usable ? 'usable' : `not usable: ${odometry.reason}`)],
      table(['', 'value', '± σ'], [
        ['speed, m/s', fixed(odometry.speed, 2), fixed(odometry.speed_sigma, 3)],
        ['yaw rate, °/s', fixed(degrees(odometry.yaw_rate), 2), fixed(degrees(odometry.yaw_rate_sigma), 3)],
        ['wheel scale', fixed(odometry.wheel_scale, 4), fixed(odometry.wheel_scale_sigma, 4)],
        ['gyroscope bias, °/s', fixed(degrees(odometry.gyro_bias), 3), fixed(degrees(odometry.gyro_bias_sigma), 3)]].filter(row => row[1] !== '')),
      table(['source', 'used', 'accepted', 'rejected'], odometry.sources.map(s => [s.name, s.carries ? 'yes' : 'no', s.accepted, s.rejected]))));
  }
  if (streetmap) {
    parts.push(part(['Street map: ', stateBadge(streetmap.state)], element('p', {}, streetmap.reason ?? ''),
      table(['', ''], [['standard deviation, m', fixed(streetmap.sigma, 2)], ['probability of being elsewhere', fixed(streetmap.elsewhere, 3)],
        ...(streetmap.places ?? []).map(p => [`${Math.round(100 * p.probability)} % at, m east, north`, `${fixed(p.x, 0)}, ${fixed(p.y, 0)}`]),
        ['particles', streetmap.particles], ['hypotheses', streetmap.hypotheses ?? ''], ['updates', streetmap.updates]])));
  }
  return parts;
}

function healthTables(health) {
  const ms = s => s.latency_ms ? [fixed(s.latency_ms.p50, 1), fixed(s.latency_ms.p99, 1), fixed(s.latency_ms.max, 1)] : ['', '', ''];
  const lost = s => Object.values(s.losses ?? {}).reduce((sum, v) => sum + (typeof v === 'number' ? v : 0), 0);
  const parts = [part('Lidars', table(['device', 'level', 'sweeps/s', 'packets/s', 'lost', 'clock', 'finding'], (health.sensors ?? []).map(s => [s.device, stateBadge(s.level),
    fixed(s.sweeps_hz, 1), fixed(s.packets_hz, 0), lost(s), s.clock ? `${s.clock.source}${s.clock.trusted ? '' : ': ' + (s.clock.reason ?? 'not trusted')}` : '', findingText(s)]))),
  part('Other devices', table(['device', 'kind', 'level', 'received/s', 'used', 'lost', 'finding'], (health.streams ?? []).map(s => [s.device, s.kind, stateBadge(s.level),
    fixed(s.received_hz, 1), s.used, s.lost, findingText(s)]))), ...motionTables(health)];
  if (health.host) {
    parts.push(part('Stages', table(['stage', 'median, ms', '99 %', 'maximum', 'runs', 'deadline misses'],
      health.host.stages.map(s => [s.stage, ...ms(s), s.count, s.deadline_misses ?? '']))),
    part('Queues', table(['queue', 'depth', 'capacity', 'lost'], health.host.queues.map(q => [q.queue, q.depth, q.capacity, q.lost]))));
  }
  return parts;
}

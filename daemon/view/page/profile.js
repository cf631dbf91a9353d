'use strict';
// The dependence of an image and its sweep around calibrations, along the six axes of the camera.

const profileAxes = ['about x, pitch', 'about y, yaw', 'about z, roll', 'x, right', 'y, down', 'z, ahead'];
/** In the order in which they are drawn: name in the message, name for people, colour, dashes. */
const profileCurves = [['saved', 'saved', 'var(--dim)', ''], ['use', 'in use', 'var(--odom)', ''],
  ['estimate', 're-estimated', 'var(--warn)', '7 5']];

/** One axis: curves [{nats, colour, dash, name}] over errors of −halfWidth … halfWidth, with a dot at each maximum; `estimate`:
 *  {at, sigma} of the error by the last images, or undefined. */
function profileChart({title, unit, digits, halfWidth, curves, low, high, estimate, width, height}) {
  const left = 8, right = width - 8, top = 36, bottom = height - 18;
  const x = v => left + (right - left) * (v + halfWidth) / (2 * halfWidth);
  const y = v => bottom - (bottom - top) * (v - low) / (high - low);
  const peak = nats => { const best = nats.indexOf(Math.max(...nats)); return [halfWidth * (2 * best / (nats.length - 1) - 1), nats[best]]; };
  const svg = element('svg', {viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'aria-label': `dependence along ${title}`});
  svg.append(element('text', {x: left, y: 14, class: 'strong'}, title));
  if (estimate) {
    const far = Math.abs(estimate.at) > 2 * estimate.sigma, at = Math.min(halfWidth, Math.max(-halfWidth, estimate.at));
    svg.append(element('text', {x: left, y: 28, class: far ? 'mark' : ''},
      `${estimate.at >= 0 ? '+' : '−'}${Math.abs(estimate.at).toFixed(digits)} ± ${estimate.sigma.toFixed(digits)} ${unit}`));
    svg.append(element('rect', {x: x(Math.max(-halfWidth, at - 2 * estimate.sigma)), y: top,
      width: x(Math.min(halfWidth, at + 2 * estimate.sigma)) - x(Math.max(-halfWidth, at - 2 * estimate.sigma)), height: bottom - top,
      fill: far ? 'var(--bad)' : 'var(--idle)', opacity: 0.22}));
  }
  svg.append(element('line', {x1: x(0), x2: x(0), y1: top, y2: bottom, stroke: 'var(--text)', 'stroke-width': 1.5}));
  for (const [v, anchor] of [[-halfWidth, 'start'], [0, 'middle'], [halfWidth, 'end']]) {
    svg.append(element('text', {x: x(v), y: height - 5, 'text-anchor': anchor}, v === 0 ? '0' : `${v > 0 ? '+' : '−'}${Math.abs(v).toFixed(unit === '°' ? 1 : 0)}`));
  }
  for (const {nats, colour, dash} of curves) {
    const at = nats.map((v, i) => [x(halfWidth * (2 * i / (nats.length - 1) - 1)), y(v)]), [u, v] = peak(nats);
    svg.append(element('path', {d: pathText(at), fill: 'none', stroke: colour, 'stroke-width': 2, 'stroke-dasharray': dash || 'none'}),
      element('circle', {cx: x(u), cy: y(v), r: 3.5, fill: colour}));
  }
  return svg;
}

/** The six axes of a camera: from a message of kind "profile" (or null) and a calibration report. */
function profileElements(frame, report, size) {
  const {reason, rotation, translation, profiles} = frame?.header ?? {};
  const known = profiles ? profileCurves.filter(([name]) => profiles[name]) : [];
  const all = known.flatMap(([name]) => profiles[name].flat());
  let low = Math.min(...all, Infinity), high = Math.max(...all, -Infinity);
  const margin = 0.08 * Math.max(high - low, 1e-6);
  [low, high] = known.length ? [low - margin, high + margin] : [0, 1];
  const scale = axis => axis < 3 ? 180 / Math.PI : 100;
  const charts = known.length === 0 && !report?.offset ? [] : profileAxes.map((title, axis) => profileChart({title, ...size, unit: axis < 3 ? '°' : 'cm', digits: axis < 3 ? 2 : 1,
    halfWidth: scale(axis) * (axis < 3 ? rotation ?? 0.035 : translation ?? 0.2), low, high,
    // A calibration that is wrong by e fits best when it is moved by −e.
    curves: known.map(([name, , colour, dash]) => ({nats: [...profiles[name][axis]].reverse(), colour, dash})),
    estimate: report?.offset && report.offset_sigma[axis] < 1e3
      ? {at: report.offset[axis] * scale(axis), sigma: report.offset_sigma[axis] * scale(axis)} : undefined}));
  const note = known.length ? [] : [element('p', {class: 'dim'}, reason ? `This image gives no profile: ${reason}.` : 'The profile of the latest image comes within two seconds.')];
  return [element('p', {class: 'profile-title'}, 'Dependence by the error that a calibration may have about and along the camera\'s axes (°, cm). Line: it is right; band: estimated error ± 2σ; dot: latest image.'),
  ...(known.length > 2 ? [legend(known.map(([, text, colour]) => [colour, text]))] : []), ...note, element('div', {class: 'profiles'}, ...charts)];
}

'use strict';
// The dependence of an image and its sweep around calibrations, along the six axes of the camera.

const profileAxes = ['pitch, about x', 'yaw, about y', 'roll, about z', 'x, to the right', 'y, down', 'z, ahead'];
/** In the order in which they are drawn: name in the message, name for people, colour, dashes. */
const profileCurves = [['saved', 'saved', 'var(--dim)', ''], ['use', 'in use', 'var(--odom)', ''],
  ['estimate', 're-estimated', 'var(--warn)', '7 5']];

/** One axis: curves [{nats, colour, dash}] over −halfWidth … halfWidth, with a dot at each maximum. */
function profileChart({title, unit, halfWidth, curves, low, high}) {
  const width = 350, height = 180, left = 46, right = width - 10, top = 26, bottom = height - 24;
  const x = v => left + (right - left) * (v + halfWidth) / (2 * halfWidth);
  const y = v => bottom - (bottom - top) * (v - low) / (high - low);
  const svg = element('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `dependence along ${title}`});
  const vertical = ticks(low, high, 3), horizontal = ticks(-halfWidth, halfWidth, 4);
  for (const v of vertical.values) {
    svg.append(element('line', {x1: left, x2: right, y1: y(v), y2: y(v), stroke: 'var(--line)'}),
      element('text', {x: left - 5, y: y(v) + 4, 'text-anchor': 'end'}, v.toFixed(vertical.digits)));
  }
  for (const v of horizontal.values) {
    svg.append(element('text', {x: x(v), y: height - 8, 'text-anchor': 'middle'}, v.toFixed(horizontal.digits)));
  }
  svg.append(element('line', {x1: x(0), x2: x(0), y1: top, y2: bottom, stroke: 'var(--text)', 'stroke-dasharray': '2 3'}),
    element('text', {x: 8, y: 16, class: 'strong'}, `${title}, ${unit}`));
  for (const {nats, colour, dash} of curves) {
    const at = nats.map((v, i) => [x(halfWidth * (2 * i / (nats.length - 1) - 1)), y(v)]);
    const best = nats.indexOf(Math.max(...nats));
    svg.append(element('path', {d: pathText(at), fill: 'none', stroke: colour, 'stroke-width': 2, 'stroke-dasharray': dash || 'none'}),
      element('circle', {cx: at[best][0], cy: at[best][1], r: 3.5, fill: colour}));
  }
  return svg;
}

/** The elements that show a message of kind "profile". */
function profileElements({reason, rotation, translation, profiles}) {
  if (reason) return [element('p', {class: 'dim'}, `no profile of the dependence: ${reason}`)];
  const known = profileCurves.filter(([name]) => profiles[name]);
  const all = known.flatMap(([name]) => profiles[name].flat());
  let low = Math.min(...all), high = Math.max(...all);
  const margin = 0.08 * Math.max(high - low, 1e-6);
  low -= margin; high += margin;
  const charts = profileAxes.map((title, axis) => profileChart({title, unit: axis < 3 ? '°' : 'cm',
    halfWidth: axis < 3 ? rotation * 180 / Math.PI : 100 * translation, low, high,
    curves: known.map(([name, , colour, dash]) => ({nats: profiles[name][axis], colour, dash}))}));
  return [element('p', {class: 'profile-title'}, 'Dependence of image and lidar, nats, around each calibration: '),
    legend(known.map(([, text, colour]) => [colour, text])), element('div', {class: 'profiles'}, ...charts)];
}

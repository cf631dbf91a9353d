'use strict';
// Drawing: elements, and charts as SVG. Texts are set as text, never as HTML.

/** An element with attributes and children; strings become text. */
function element(tag, attributes = {}, ...children) {
  const svg = ['svg', 'line', 'path', 'rect', 'text', 'circle', 'ellipse', 'image', 'g', 'title'].includes(tag);
  const made = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** The numbers at which an axis from low to high is labelled: 1, 2 or 5 times a power of ten. */
function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw * 0.999);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) values.push(k * step);
  return {values, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

/** A path through points [x, y] in pixels; a step keeps each value until the next. */
function pathText(points, step) {
  let text = '';
  points.forEach(([x, y], i) => {
    if (i > 0 && step) text += `H${x.toFixed(1)}`;
    text += `${i > 0 ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`;
  });
  return text;
}

/**
 * A chart over time. lines: [{points: [[t, value]], colour, step, dots, dash, label}]; bands: [{points: [[t, low, high]],
 * colour}]; spans: [{from, to, colour, name}] behind everything; marks: [{t, name}]; cursor: a time, or undefined.
 */
function timeChart({title, unit, duration, lines, bands = [], spans = [], marks = [], height = 230, width = 1060,
                    zero = false, cursor}) {
  const all = lines.flatMap(l => l.points.map(p => p[1])).concat(bands.flatMap(b => b.points.flatMap(p => [p[1], p[2]])));
  const finite = all.filter(Number.isFinite);
  if (finite.length === 0) return element('p', {class: 'note'}, `${title}: no values`);
  let low = finite.reduce((a, b) => Math.min(a, b)), high = finite.reduce((a, b) => Math.max(a, b));
  if (zero) low = Math.min(0, low);
  if (high - low < 1e-9) { high += 0.5; low -= zero ? 0 : 0.5; }
  const margin = (high - low) * (spans.length ? 0.25 : 0.08);  // names of spans are above the lines
  high += margin;
  if (!(zero && low === 0)) low -= margin;
  const left = 58, right = width - 12, top = 26, bottom = height - 26;
  const x = t => left + (right - left) * t / Math.max(duration, 1e-9);
  const y = v => bottom - (bottom - top) * (v - low) / (high - low);
  const svg = element('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': title});
  const names = [];  // of spans and lines: above everything, with a rim
  for (const s of spans) {
    svg.append(element('rect', {x: x(s.from), y: top, width: Math.max(0, x(s.to) - x(s.from)), height: bottom - top,
      fill: s.colour, opacity: 0.16}, element('title', {}, s.name)));
    if (x(s.to) - x(s.from) > 8 * s.name.length + 8) {
      names.push(element('text', {x: x(s.from) + 4, y: top + 13, class: 'over'}, s.name));
    }
  }
  const vertical = ticks(low, high, 4);
  for (const v of vertical.values) {
    svg.append(element('line', {x1: left, x2: right, y1: y(v), y2: y(v), stroke: 'var(--line)'}),
               element('text', {x: left - 6, y: y(v) + 4, 'text-anchor': 'end'}, v.toFixed(vertical.digits)));
  }
  const horizontal = ticks(0, Math.max(duration, 1e-3), Math.min(10, width / 90));
  for (const t of horizontal.values) {
    const label = t.toFixed(horizontal.digits) + (t === horizontal.values.at(-1) ? ' s' : '');
    svg.append(element('text', {x: Math.min(x(t), right - 8), y: height - 9, 'text-anchor': 'middle'}, label));
  }
  svg.append(element('text', {x: 8, y: 16, class: 'strong'}, unit ? `${title}, ${unit}` : title));
  for (const b of bands) {
    const edge = b.points.map(p => [x(p[0]), y(p[1])]).concat(b.points.map(p => [x(p[0]), y(p[2])]).reverse());
    svg.append(element('path', {d: pathText(edge) + 'Z', fill: b.colour, opacity: 0.22}));
  }
  for (const l of lines) {
    const points = l.points.filter(p => Number.isFinite(p[1])).map(p => [x(p[0]), y(p[1])]);
    const path = element('path', {d: pathText(points, l.step), fill: 'none', stroke: l.colour, 'stroke-width': 2,
      'stroke-linejoin': 'round'});
    if (l.dash) path.setAttribute('stroke-dasharray', '6 4');
    svg.append(path);
    if (l.label && points.length) {
      names.push(element('text', {x: right - 4, y: Math.max(top + 26, points.at(-1)[1] - 6), 'text-anchor': 'end', fill: l.colour, class: 'over'}, l.label));
    }
    if (l.dots) {
      l.points.forEach(p => svg.append(element('circle', {cx: x(p[0]), cy: y(p[1]), r: 3.5, fill: l.colour},
        element('title', {}, p[2] ?? ''))));
    }
  }
  for (const m of marks) {
    const end = x(m.t) > right - 200;
    svg.append(element('line', {x1: x(m.t), x2: x(m.t), y1: top, y2: bottom, stroke: 'var(--text)', 'stroke-dasharray': '2 3'}),
               element('text', {x: x(m.t) + (end ? -5 : 5), y: top + 30, 'text-anchor': end ? 'end' : 'start',
                 class: 'mark over'}, m.name));
  }
  if (cursor !== undefined) {
    svg.append(element('line', {x1: x(cursor), x2: x(cursor), y1: top, y2: bottom, stroke: 'var(--text)', 'stroke-width': 1.5, class: 'cursor'}));
  }
  svg.append(...names);
  return svg;
}

/** A plan with equal scales. paths: [{x, y, colour, width, name}]; ellipses: [{x, y, xx, xy, yy}]; image or null. */
function planChart({paths, ellipses, image}) {
  const xs = paths.flatMap(p => p.x), ys = paths.flatMap(p => p.y);
  const extent = v => [v.reduce((a, b) => Math.min(a, b)), v.reduce((a, b) => Math.max(a, b))];
  let [west, east] = extent(xs), [south, north] = extent(ys);
  const margin = Math.max(5, 0.05 * Math.max(east - west, north - south));
  west -= margin; east += margin; south -= margin; north += margin;
  const lack = (east - west) / 2 - (north - south);  // at most twice as wide as high
  if (lack > 0) { south -= lack / 2; north += lack / 2; }
  const width = 1060, scale = Math.min(width / (east - west), 720 / (north - south)), height = (north - south) * scale;
  const shift = (width - (east - west) * scale) / 2;
  const x = v => shift + (v - west) * scale, y = v => height - (v - south) * scale;
  const svg = element('svg', {viewBox: `0 0 ${width} ${height.toFixed(0)}`, role: 'img', 'aria-label': 'plan of the track'});
  if (image) {
    svg.append(element('image', {href: image.url, x: x(image.x), y: y(image.y + image.height),
      width: image.width * scale, height: image.height * scale, preserveAspectRatio: 'none'}));
  }
  for (const p of paths) {
    svg.append(element('path', {d: pathText(p.x.map((v, i) => [x(v), y(p.y[i])])), fill: 'none', stroke: p.colour,
      'stroke-width': p.width, 'stroke-linejoin': 'round', 'stroke-linecap': 'round', opacity: p.opacity ?? 1}));
  }
  for (const e of ellipses) {
    // 99 % of a plane's normal distribution lie within sqrt(9.21) standard deviations.
    const mean = (e.xx + e.yy) / 2, root = Math.hypot((e.xx - e.yy) / 2, e.xy);
    const axis = v => Math.sqrt(9.21 * Math.max(v, 0)) * scale;
    const turn = -0.5 * Math.atan2(2 * e.xy, e.xx - e.yy) * 180 / Math.PI;
    svg.append(element('ellipse', {rx: axis(mean + root), ry: axis(mean - root), fill: 'none', stroke: e.colour,
      transform: `translate(${x(e.x)} ${y(e.y)}) rotate(${turn})`, opacity: 0.8}));
  }
  const bar = 10 ** Math.floor(Math.log10((east - west) / 4));
  svg.append(element('line', {x1: 14, x2: 14 + bar * scale, y1: height - 14, y2: height - 14, stroke: 'var(--scale)',
    'stroke-width': 4}), element('text', {x: 14, y: height - 22, class: 'scale'}, `${bar} m`));
  svg.style.setProperty('--scale', image ? '#111' : 'var(--text)');
  return svg;
}

/** A legend: [[colour, text]]. */
function legend(entries) {
  return element('div', {class: 'legend'}, ...entries.map(([colour, text]) => {
    const line = element('i');
    line.style.background = colour;
    return element('span', {}, line, text);
  }));
}

/** A table; cells that are numbers are aligned to the right. */
function table(head, rows) {
  const cell = (tag, value) => typeof value === 'number' || value instanceof Number
    ? element(tag, {class: 'number'}, String(value)) : element(tag, {}, value ?? '');
  return element('div', {class: 'scroll'}, element('table', {},
    element('tr', {}, ...head.map((h, i) => element('th', {class: typeof rows[0]?.[i] === 'number' ? 'number' : ''}, h))),
    ...rows.map(row => element('tr', {}, ...row.map(value => cell('td', value))))));
}

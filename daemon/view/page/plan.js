'use strict';
// The plan: street map, track, ellipse of the position, vehicle; north is up.

/** Kinds of segments (fusion/streetmap/segment.hpp), in their order: name, colour in light and in dark. Muted, so that
 *  the track stands out. */
const segmentKinds = [['open land', [243, 242, 238], [18, 22, 26]], ['carriageway', [214, 215, 219], [52, 56, 62]],
  ['kerb', [176, 178, 184], [96, 100, 106]], ['sidewalk', [232, 228, 219], [62, 60, 52]], ['footway', [236, 226, 210], [70, 58, 44]],
  ['crossing', [230, 222, 186], [92, 88, 46]], ['green', [222, 234, 216], [26, 46, 30]], ['water', [208, 224, 238], [24, 40, 66]],
  ['paved', [234, 230, 238], [48, 42, 56]], ['building', [222, 212, 206], [60, 46, 44]], ['wall', [178, 164, 158], [116, 92, 88]],
  ['region', [230, 230, 230], [44, 44, 44]], ['line', [150, 150, 150], [120, 120, 120]]];

/** RGBA of segment kinds. */
function segmentPixels(kinds, light) {
  const pixels = new Uint8ClampedArray(4 * kinds.length);
  for (let i = 0; i < kinds.length; ++i) pixels.set([...(segmentKinds[kinds[i]] ?? segmentKinds[0])[light ? 1 : 2], 255], 4 * i);
  return pixels;
}

/** Makes a canvas as many pixels large as it is shown. */
function fitCanvas(canvas, ratio = Math.min(2, window.devicePixelRatio || 1)) {
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  return ratio;
}

const isLight = () => !matchMedia('(prefers-color-scheme: dark)').matches;
const earthRadius = 6378137, earthFlattening = 1 / 298.257223563;  // WGS 84

/** Latitude and longitude, degrees, of a point near the map's origin. */
function toDegrees([latitude, longitude], east, north) {
  const e2 = earthFlattening * (2 - earthFlattening), s = Math.sin(latitude * Math.PI / 180), w = Math.sqrt(1 - e2 * s * s);
  return [latitude + north / (earthRadius * (1 - e2) / w ** 3) * 180 / Math.PI,
    longitude + east / (earthRadius / w * Math.cos(latitude * Math.PI / 180)) * 180 / Math.PI];
}

class Plan {
  constructor(canvas) {
    this.canvas = canvas;
    this.scale = 4;      // px/m
    this.middle = null;  // m; null: the vehicle
    this.track = [];     // {t, odom: [x, y, yaw], map: [x, y, yaw] or null, covariance}
    this.parts = [];     // of the map, drawn once for each colour scheme
    this.now = Infinity;
    const held = new Map();
    const at = (event, action) => canvas.addEventListener(event, action);
    at('pointerdown', e => { held.set(e.pointerId, [e.clientX, e.clientY]); canvas.setPointerCapture(e.pointerId); });
    for (const name of ['pointerup', 'pointercancel']) at(name, e => held.delete(e.pointerId));
    at('pointerleave', () => { place('plan-value').textContent = ''; });
    at('pointermove', e => {
      const last = held.get(e.pointerId);
      if (!last) return this.showValue(e.offsetX, e.offsetY);
      const apart = () => { const [a, b] = held.values(); return Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1])); };
      const before = held.size === 2 ? apart() : 0, middle = this.centre();
      held.set(e.pointerId, [e.clientX, e.clientY]);
      this.middle = [middle[0] - (e.clientX - last[0]) / this.scale / held.size, middle[1] + (e.clientY - last[1]) / this.scale / held.size];
      if (held.size === 2) this.zoom(apart() / before);
      this.draw();
    });
    at('wheel', e => { e.preventDefault(); this.zoom(Math.exp(-e.deltaY * 0.001)); });
    at('dblclick', () => this.reset());
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  reset() { this.middle = null; this.scale = 4; this.draw(); }
  zoom(factor) { this.scale = Math.min(60, Math.max(0.1, this.scale * factor)); this.draw(); }

  add(frame) {
    const {T_odom_vehicle: O, T_map_vehicle: M, covariance_map: covariance, stamp, particles} = frame.header;
    if (!O && !M) return;
    const pose = T => [T[3], T[7], Math.atan2(T[4], T[0])];
    this.track.push({t: Number(stamp) / 1e9, odom: O ? pose(O) : null, map: M ? pose(M) : null, covariance, particles});
    if (this.track.length > 20000) this.track = this.track.filter((_, i) => i % 2 || i > 10000);
  }

  addMap(frame) {
    this.parts.push({frame});
    if (this.parts.length > 64) this.parts.shift();
  }

  /** The last place at the time that is shown. */
  place() {
    for (let i = this.track.length - 1; i >= 0; --i) if (this.track[i].t <= this.now + 1e-3) return this.track[i];
    return null;
  }

  /** On the map if there has been a place there. */
  pose(at) { return at && (this.onMap() ? at.map : at.odom); }
  onMap() { return this.track.some(at => at.map); }
  centre() { return this.middle ?? this.pose(this.place())?.slice(0, 2) ?? this.drawnCentre ?? [0, 0]; }

  toMetres(u, v) {
    const [x, y] = this.centre();
    return [x + (u - this.canvas.clientWidth / 2) / this.scale, y - (v - this.canvas.clientHeight / 2) / this.scale];
  }

  kindAt(x, y) {
    for (let i = this.parts.length - 1; i >= 0; --i) {
      const {header, rest} = this.parts[i].frame;
      const [column, row] = [Math.floor((x - header.x) / header.cell), Math.floor((y - header.y) / header.cell)];
      if (column >= 0 && row >= 0 && column < header.columns && row < header.rows) return segmentKinds[rest[row * header.columns + column]]?.[0];
    }
    return null;
  }

  origin() { return this.parts.at(-1)?.frame.header.origin_deg; }

  showValue(u, v) {
    const [x, y] = this.toMetres(u, v), kind = this.kindAt(x, y);
    const degrees = this.onMap() && this.origin() ? toDegrees(this.origin(), x, y).map(d => `${d.toFixed(5)}°`).join(' ') : '';
    place('plan-value').textContent = [this.onMap() ? `east ${x.toFixed(1)} m, north ${y.toFixed(1)} m` : `x ${x.toFixed(1)} m, y ${y.toFixed(1)} m`,
      degrees, kind].filter(Boolean).join(', ');
  }

  draw() {
    const {canvas} = this;
    if (canvas.clientWidth === 0) return;
    const ratio = fitCanvas(canvas), context = canvas.getContext('2d'), light = isLight();
    const [width, height] = [canvas.clientWidth, canvas.clientHeight], [cx, cy] = this.drawnCentre = this.centre();
    const x = v => width / 2 + (v - cx) * this.scale, y = v => height / 2 - (v - cy) * this.scale;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = cssColour(segmentKinds[0][light ? 1 : 2]);
    context.fillRect(0, 0, width, height);
    const onMap = this.onMap();
    if (onMap) for (const part of this.parts) this.drawPart(context, part, light, x, y);
    this.drawGrid(context, light, x, y);
    const line = (points, colour, wide) => {
      context.strokeStyle = colour;
      context.lineWidth = wide;
      context.lineJoin = 'round';
      context.beginPath();
      points.forEach((at, i) => context[i && Math.hypot(at[0] - points[i - 1][0], at[1] - points[i - 1][1]) < 100 ? 'lineTo' : 'moveTo'](x(at[0]), y(at[1])));
      context.stroke();
    };
    const poses = this.track.map(at => [at.t, this.pose(at)]).filter(([, at]) => at);
    const [past, ahead] = [poses.filter(([t]) => t <= this.now + 1e-3), poses.filter(([t]) => t > this.now)].map(list => list.map(([, at]) => at));
    line(ahead, light ? '#8aa4c0' : '#4d6680', 2);
    line(past, light ? '#fff' : '#000', 6);
    line(past, trackColour(light), 3);
    const here = this.place(), pose = this.pose(here);
    if (pose && here.covariance && onMap) {
      line(Array.from({length: 65}, (_, k) => ellipsePoint(here.covariance, k * Math.PI / 32).map((d, i) => d + pose[i])), ellipseColour(light), 2.5);
      context.fillStyle = ellipseColour(light);
      for (let i = 0; i + 1 < here.particles.length; i += 2) context.fillRect(x(here.particles[i]) - 1, y(here.particles[i + 1]) - 1, 2, 2);
    }
    if (pose) this.drawVehicle(context, light, x(pose[0]), y(pose[1]), pose[2]);
    this.drawScale(context, light, width, height, onMap);
    this.legend(onMap);
  }

  drawPart(context, part, light, x, y) {
    const {header, rest} = part.frame;
    if (part.light !== light) {
      part.image = new OffscreenCanvas(header.columns, header.rows);
      part.image.getContext('2d').putImageData(new ImageData(segmentPixels(rest, light), header.columns, header.rows), 0, 0);
      part.light = light;
    }
    const size = [header.columns * header.cell, header.rows * header.cell];
    context.save();
    context.translate(x(header.x), y(header.y));
    context.scale(1, -1);  // rows are from the south
    context.imageSmoothingEnabled = this.scale * header.cell < 4;
    context.drawImage(part.image, 0, 0, size[0] * this.scale, size[1] * this.scale);
    context.restore();
  }

  drawGrid(context, light, x, y) {
    const step = [10, 20, 50, 100, 200, 500, 1000].find(s => s * this.scale > 60) ?? 2000;
    const [[west, north], [east, south]] = [this.toMetres(0, 0), this.toMetres(this.canvas.clientWidth, this.canvas.clientHeight)];
    context.strokeStyle = light ? 'rgba(0,0,0,.09)' : 'rgba(255,255,255,.09)';
    context.lineWidth = 1;
    context.beginPath();
    for (let v = Math.ceil(west / step) * step; v <= east; v += step) { context.moveTo(x(v), 0); context.lineTo(x(v), this.canvas.clientHeight); }
    for (let v = Math.ceil(south / step) * step; v <= north; v += step) { context.moveTo(0, y(v)); context.lineTo(this.canvas.clientWidth, y(v)); }
    context.stroke();
  }

  drawVehicle(context, light, u, v, yaw) {
    context.save();
    context.translate(u, v);
    context.rotate(-yaw);
    context.beginPath();
    for (const at of [[13, 0], [-8, 7], [-4, 0], [-8, -7]]) context.lineTo(...at);
    context.closePath();
    context.fillStyle = light ? '#111' : '#fff';
    context.strokeStyle = light ? '#fff' : '#000';
    context.lineWidth = 1.5;
    context.fill();
    context.stroke();
    context.restore();
  }

  drawScale(context, light, width, height, onMap) {
    const metres = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find(s => s * this.scale > 60) ?? 2000;
    context.fillStyle = context.strokeStyle = light ? '#1d2329' : '#e4e8ec';
    context.lineWidth = 2;
    context.beginPath();
    for (const [u, v] of [[12, height - 16], [12, height - 11], [12 + metres * this.scale, height - 11], [12 + metres * this.scale, height - 16]]) context.lineTo(u, v);
    context.stroke();
    context.font = '12px system-ui, sans-serif';
    context.textAlign = 'left';
    context.fillText(`${metres} m`, 18, height - 17);
    context.textAlign = 'center';
    context.fillText(onMap ? 'N' : 'ahead at the start', onMap ? width - 18 : width - 76, onMap ? 32 : 18);
    context.beginPath();
    if (onMap) { context.moveTo(width - 18, 8); context.lineTo(width - 13, 20); context.lineTo(width - 23, 20); } else {
      context.moveTo(width - 8, 14); context.lineTo(width - 16, 10); context.lineTo(width - 16, 18); }
    context.fill();
  }

  /** What the colours mean; kinds of areas only with a map. */
  legend(onMap) {
    const light = isLight(), key = `${onMap} ${light} ${this.parts.length > 0}`;
    if (this.legendKey === key) return;
    this.legendKey = key;
    const entries = [[trackColour(light), onMap ? 'track on the street map' : 'track by odometry']];
    if (onMap) entries.push([ellipseColour(light), 'position, 99 %']);
    const areas = onMap ? [1, 3, 4, 6, 7, 9].map(kind => [cssColour(segmentKinds[kind][light ? 1 : 2]), segmentKinds[kind][0], true]) : [];
    place('plan-legend').replaceChildren(legend(entries), ...(areas.length ? [areaLegend(areas)] : []));
  }
}

const trackColour = light => light ? '#0072b2' : '#56b4e9', ellipseColour = light => light ? '#d55e00' : '#f5a623';

/** A legend of areas: [[colour, text]]. */
function areaLegend(entries) {
  const made = legend(entries.map(([colour, text]) => [colour, text]));
  made.classList.add('areas');
  return made;
}

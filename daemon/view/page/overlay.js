'use strict';
// A camera's image with the lidar over it.

/** Pixel of a point in the camera's frame, or null; the models of infuse's rig (pinhole: Brown–Conrady, fisheye:
 *  Kannala–Brandt). */
function projectPoint(camera, x, y, z) {
  const [k1, k2, p1, p2, k3] = camera.distortion;
  if (camera.model === 'fisheye') {
    const r = Math.hypot(x, y), angle = Math.atan2(r, z);
    if (angle > 1.5) return null;
    const a2 = angle * angle;
    const bent = angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (p1 + a2 * p2))));
    const scale = r > 1e-9 ? bent / r : 1;
    return [camera.fx * x * scale + camera.cx, camera.fy * y * scale + camera.cy];
  }
  if (z < 0.3) return null;
  const a = x / z, b = y / z, r2 = a * a + b * b;
  if (r2 > 4) return null;  // a polynomial folds back far outside
  const radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return [camera.fx * (a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)) + camera.cx,
          camera.fy * (b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b) + camera.cy];
}

/** Of the colours of distance, as CSS. */
const rangeTable = Array.from({length: 64}, (_, i) => cssColour(scaleColour(viridis, i / 63)));
const edgeRatio = 1.25;      // of the range beyond an edge to that of the edge
const arrowFactor = 5, maxArrows = 400;
const meanings = {use: 'in use', saved: 'saved', estimate: 're-estimated'};

/** exp of a twist (rx, ry, rz, tx, ty, tz) times T; to first order in the translation, which is small. */
function moved(T, twist) {
  const [rx, ry, rz, tx, ty, tz] = twist, angle = Math.hypot(rx, ry, rz) || 1e-12, [a, b, c] = [rx / angle, ry / angle, rz / angle];
  const [s, v, k] = [Math.sin(angle), 1 - Math.cos(angle), Math.cos(angle)];
  return matrices.multiply([k + a * a * v, a * b * v - c * s, a * c * v + b * s, tx, b * a * v + c * s, k + b * b * v, b * c * v - a * s, ty,
    c * a * v - b * s, c * b * v + a * s, k + c * c * v, tz, 0, 0, 0, 1], T);
}

class Overlay {
  constructor(parent, device) {
    this.device = device;
    this.canvas = element('canvas', {role: 'img', 'aria-label': `image of ${device} with the lidar over it`});
    this.choice = element('select', {'aria-label': 'lidar drawn by the calibration'});
    this.value = element('span', {class: 'value'});
    this.note = element('span', {class: 'dim note'});
    this.name = element('b', {}, device);
    this.state = element('span');
    this.box = element('div', {class: 'overlay'}, element('div', {class: 'caption'}, this.name, ' ', this.state,
      element('label', {}, 'calibration ', this.choice), this.note),
    element('div', {class: 'image'}, this.canvas, this.value));
    parent.append(this.box);
    this.offer();
    this.choice.addEventListener('input', () => this.draw());
    this.canvas.addEventListener('pointermove', e => this.point([e.offsetX * this.canvas.width / this.canvas.clientWidth, e.offsetY * this.canvas.height / this.canvas.clientHeight]));
    this.canvas.addEventListener('pointerleave', () => this.point(null));
  }

  /** The calibrations that there are. */
  offer() {
    const names = ['use', 'saved', ...(this.estimate ? ['estimate'] : [])];
    if (this.choice.options.length === names.length) return;
    const chosen = this.choice.value || 'use';
    this.choice.replaceChildren(...names.map(name => element('option', {value: name}, meanings[name])));
    this.choice.value = names.includes(chosen) ? chosen : 'use';
  }

  /** A calibration report, or undefined. */
  calibrated(report) {
    this.report = report;
    this.estimate = report?.estimate?.T_camera_lidar;
    this.offer();
    this.state.replaceChildren(...(report ? [stateBadge(report.state)] : []));
    this.draw();
  }

  /** Draws the latest frame; while one is decoded, another waits. */
  async show() {
    if (this.busy || !this.latest || this.latest === this.frame) return;
    this.busy = true;
    const frame = this.latest;
    try {
      this.image = await createImageBitmap(new Blob([frame.rest], {type: 'image/jpeg'}));
      this.frame = frame;
      this.edges = null;
      this.draw();
    } finally {
      this.busy = false;
    }
    if (this.latest !== frame) this.show();
  }

  calibration() {
    const {T_camera_lidar, T_camera_lidar_rig} = this.frame.header;
    return {use: T_camera_lidar, saved: T_camera_lidar_rig, estimate: this.estimate}[this.choice.value] ?? T_camera_lidar;
  }

  project(T, i) {
    const {header, points} = this.frame, x = 0.01 * points.x[i], y = 0.01 * points.y[i], z = 0.01 * points.z[i];
    const depth = T[8] * x + T[9] * y + T[10] * z + T[11];
    if (depth < 0.3 && header.model !== 'fisheye') return null;
    const pixel = projectPoint(header, T[0] * x + T[1] * y + T[2] * z + T[3], T[4] * x + T[5] * y + T[6] * z + T[7], depth);
    return pixel && pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < header.width && pixel[1] < header.height ? pixel : null;
  }

  draw() {
    if (!this.frame || !this.box.clientWidth) return;
    const {header, points} = this.frame, T = this.calibration(), context = this.canvas.getContext('2d');
    [this.canvas.width, this.canvas.height] = [header.width, header.height];
    // As large as its panel, whatever the image's size; where panels are swiped, as wide (style.css).
    const {clientWidth, clientHeight} = this.canvas.parentElement, scale = Math.min(clientWidth / header.width, clientHeight / header.height);
    [this.canvas.style.width, this.canvas.style.height] = [`${Math.floor(header.width * scale)}px`, `${Math.floor(header.height * scale)}px`];
    context.drawImage(this.image, 0, 0, header.width, header.height);
    const size = Math.max(1.5, header.width / 640 * remembered.size), drawn = this.drawn = [];
    context.globalAlpha = remembered.opacity;
    for (let i = 0; i < header.points; ++i) {
      const pixel = this.project(T, i);
      if (!pixel) continue;
      const range = 0.01 * Math.hypot(points.x[i], points.y[i], points.z[i]);
      drawn.push([pixel[0], pixel[1], i, range]);
      if (remembered.opacity === 0) continue;
      context.fillStyle = rangeTable[Math.round(63 * quantities.range.share(range))];
      context.fillRect(pixel[0] - size / 2, pixel[1] - size / 2, size, size);
    }
    context.globalAlpha = 1;
    this.showNote();
    if (remembered.arrows) this.drawArrows(context, T);
    this.showPointer(context);
  }

  showNote() {
    if (this.drawn && this.frame) this.note.textContent = `${this.drawn.length} returns${ageText(this.frame.header)}`;
  }

  /** Where the report says that the calibration in use is wrong: by how much the pixels are off. */
  correction() {
    const {offset, offset_sigma: sigma, state} = this.report ?? {};
    if (!offset || !['SUSPECTED', 'CONFIRMED', 'RECALIBRATING', 'UNUSABLE'].includes(state)) return null;
    // What is not significant, at two standard deviations, is not drawn.
    const twist = offset.map((v, i) => Math.abs(v) > 2 * sigma[i] ? -v : 0);
    return twist.some(v => v) ? twist : null;
  }

  /** Returns at whose side the range jumps to one farther away: on the same ring, next in azimuth. */
  findEdges() {
    const {header, points} = this.frame, order = this.drawn.map(([, , i, range]) => [points.ring[i], Math.atan2(points.y[i], points.x[i]), i, range])
      .sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const edges = [];
    for (let k = 1; k < order.length; ++k) {
      const [a, b] = [order[k - 1], order[k]];
      if (a[0] !== b[0] || b[1] - a[1] > 0.02) continue;
      if (b[3] > edgeRatio * a[3]) edges.push(a[2]);
      if (a[3] > edgeRatio * b[3]) edges.push(b[2]);
    }
    const step = Math.max(1, Math.ceil(edges.length / maxArrows));
    return edges.filter((_, k) => k % step === 0);
  }

  /** From where the lidar's edges are drawn to where they should be, five times as long. */
  drawArrows(context, T) {
    const twist = this.correction();
    if (!twist || this.choice.value !== 'use') return;
    this.edges ??= this.findEdges();
    const right = moved(T, twist), unit = this.canvas.width / 640;
    context.strokeStyle = '#fff';
    for (const [colour, width] of [['#000', 3.4], ['#ff5fc4', 1.8]]) {
      context.strokeStyle = colour;
      context.lineWidth = width * unit;
      context.beginPath();
      for (const i of this.edges) {
        const from = this.project(T, i), to = this.project(right, i);
        if (!from || !to) continue;
        const [dx, dy] = [arrowFactor * (to[0] - from[0]), arrowFactor * (to[1] - from[1])], length = Math.hypot(dx, dy);
        if (length < 2) continue;
        const [u, v] = [from[0] + dx, from[1] + dy], head = Math.min(5 * unit, length / 2), [a, b] = [dx / length * head, dy / length * head];
        context.moveTo(...from);
        context.lineTo(u, v);
        context.moveTo(u - a - b / 2, v - b + a / 2);
        context.lineTo(u, v);
        context.lineTo(u - a + b / 2, v - b - a / 2);
      }
      context.stroke();
    }
    this.note.textContent += `; arrows to where edges should be, × ${arrowFactor}`;
  }

  point(at) {
    this.pointer = at;
    this.draw();
  }

  /** The colour of a pixel, and the return that is drawn nearest to it. */
  showPointer(context) {
    if (!this.pointer) { this.value.textContent = ''; return; }
    const [u, v] = this.pointer.map(Math.floor);
    this.sample ??= new OffscreenCanvas(1, 1).getContext('2d', {willReadFrequently: true});
    this.sample.drawImage(this.image, u, v, 1, 1, 0, 0, 1, 1);
    const rgb = [...this.sample.getImageData(0, 0, 1, 1).data].slice(0, 3);
    let best = null;
    for (const [x, y, i, range] of this.drawn) {
      const apart = Math.hypot(x - u, y - v);
      if (!best || apart < best.apart) best = {apart, x, y, i, range};
    }
    const near = best && best.apart < 0.05 * this.canvas.width;
    this.value.textContent = `pixel ${u}, ${v}: red ${rgb[0]}, green ${rgb[1]}, blue ${rgb[2]}; ` + (near
      ? `nearest return ${best.apart.toFixed(1)} px away: range ${best.range.toFixed(2)} m, reflectivity ${(this.frame.points.reflectivity[best.i] / 2.55).toFixed(0)} %, ring ${this.frame.points.ring[best.i]}`
      : 'no return near');
    if (!near) return;
    context.strokeStyle = '#fff';
    context.lineWidth = this.canvas.width / 400;
    context.strokeRect(best.x - 5, best.y - 5, 10, 10);
  }
}

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

/** Red near, blue far. */
const rangeColours = Array.from({length: 64}, (_, i) => `hsl(${Math.round(i * 240 / 63)} 90% 55%)`);

class Overlay {
  constructor(parent, device) {
    this.canvas = element('canvas', {role: 'img', 'aria-label': `image of ${device} with the lidar over it`});
    this.other = element('select', {'aria-label': 'other calibration'}, element('option', {value: 'rig'}, 'saved'),
      element('option', {value: 'estimate'}, 're-estimated'));
    this.share = element('input', {type: 'range', min: 0, max: 1, step: 0.02, value: 1, 'aria-label': 'from the other to the one in use'});
    this.note = element('span', {class: 'dim'});
    this.profile = element('div');
    parent.append(element('div', {class: 'overlay'}, element('h3', {}, device), this.canvas,
      element('div', {class: 'tools'}, element('label', {}, 'Calibration ', this.other, ' ', this.share, ' in use'), this.note), this.profile));
    for (const control of [this.other, this.share]) control.addEventListener('input', () => this.draw());
  }

  /** Draws the latest frame; while one is decoded, another waits. */
  async show() {
    if (this.busy || !this.latest || this.latest === this.frame) return;
    this.busy = true;
    const frame = this.latest;
    try {
      this.image = await createImageBitmap(new Blob([frame.rest], {type: 'image/jpeg'}));
      this.frame = frame;
      this.draw();
    } finally {
      this.busy = false;
    }
    if (this.latest !== frame) this.show();
  }

  /** Between the other calibration and the one in use; they are near to each other. */
  calibration() {
    const use = this.frame.header.T_camera_lidar;
    const other = this.other.value === 'estimate' ? this.estimate ?? use : this.frame.header.T_camera_lidar_rig;
    const share = Number(this.share.value);
    return use.map((v, i) => share * v + (1 - share) * other[i]);
  }

  /** Shows a message of kind "profile"; null: none. */
  showProfile(frame) {
    if (frame === this.shownProfile) return;
    this.shownProfile = frame;
    this.profile.replaceChildren(...(frame ? profileElements(frame.header) : []));
  }

  draw() {
    if (!this.frame) return;
    const {header, points} = this.frame, T = this.calibration(), context = this.canvas.getContext('2d');
    this.canvas.width = header.width;
    this.canvas.height = header.height;
    context.drawImage(this.image, 0, 0, header.width, header.height);
    const size = Math.max(2, header.width / 500);
    let shown = 0;
    for (let i = 0; i < header.points; ++i) {
      const x = 0.01 * points.x[i], y = 0.01 * points.y[i], z = 0.01 * points.z[i];
      const depth = T[8] * x + T[9] * y + T[10] * z + T[11];
      if (depth < 0.3 && header.model !== 'fisheye') continue;
      const pixel = projectPoint(header, T[0] * x + T[1] * y + T[2] * z + T[3], T[4] * x + T[5] * y + T[6] * z + T[7], depth);
      if (!pixel || pixel[0] < 0 || pixel[1] < 0 || pixel[0] >= header.width || pixel[1] >= header.height) continue;
      context.fillStyle = rangeColours[Math.min(63, Math.floor(9 * Math.log2(1 + Math.hypot(x, y, z) / 3)))];
      context.fillRect(pixel[0] - size / 2, pixel[1] - size / 2, size, size);
      ++shown;
    }
    this.note.textContent = `${shown} returns in view`;
  }
}

'use strict';
// Returns in the colours of a camera's image.

const unseenColour = [64, 68, 74];  // of a return outside the image

/** The returns of image frames, each with the colour of its pixel. Hidden returns take that of what hides them. */
class ImageColours {
  /** `changed` is called when a new image has been decoded. */
  constructor(changed) {
    this.changed = changed;
    this.cameras = new Map();  // device → {latest, busy, cloud}
  }

  add(frame) {
    const {device} = frame.header;
    if (!this.cameras.has(device)) this.cameras.set(device, {});
    this.cameras.get(device).latest = frame;
    if (this.wanted) this.decode(this.cameras.get(device));
  }

  /** Images are decoded only while somebody wants their colours. */
  want(wanted) {
    this.wanted = wanted;
    if (wanted) this.cameras.forEach(camera => this.decode(camera));
  }

  async decode(camera) {
    const frame = camera.latest;
    if (camera.busy || camera.cloud?.frame === frame) return;
    camera.busy = true;
    try {
      const image = await createImageBitmap(new Blob([frame.rest], {type: 'image/jpeg'}));
      const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const first = camera === this.cameras.values().next().value;
      camera.cloud = colouredReturns(frame, context.getImageData(0, 0, image.width, image.height), first);
      this.changed();
    } finally {
      camera.busy = false;
    }
    if (this.wanted && camera.latest !== frame) this.decode(camera);
  }

  /** What can be drawn: [{header, x, y, z, colour, count}]. */
  clouds() { return [...this.cameras.values()].map(camera => camera.cloud).filter(Boolean); }
}

/** The returns of a frame with their colours; those outside the image only if `all`. */
function colouredReturns(frame, {width, height, data}, all) {
  const {header, points} = frame, T = header.T_camera_lidar;
  const [x, y, z] = [0, 1, 2].map(() => new Int16Array(header.points)), colour = new Uint8Array(3 * header.points);
  let count = 0;
  for (let i = 0; i < header.points; ++i) {
    const at = [points.x[i], points.y[i], points.z[i]].map(v => 0.01 * v);
    const [right, down, depth] = [0, 4, 8].map(row => T[row] * at[0] + T[row + 1] * at[1] + T[row + 2] * at[2] + T[row + 3]);
    const pixel = depth > 0.3 || header.model === 'fisheye' ? projectPoint(header, right, down, depth) : null;
    const [u, v] = pixel ? pixel.map(Math.round) : [-1, -1];
    const seen = u >= 0 && v >= 0 && u < width && v < height;
    if (!seen && !all) continue;
    const from = 4 * (v * width + u);
    colour.set(seen ? data.subarray(from, from + 3) : unseenColour, 3 * count);
    [x[count], y[count], z[count++]] = [points.x[i], points.y[i], points.z[i]];
  }
  return {frame, header, x, y, z, colour, count};
}

'use strict';
// The sweep in three dimensions, in the vehicle's frame: x forward, y left, z up.

/** Products and inverses of 4 × 4 matrices, row by row. */
const matrices = {
  multiply(a, b) {
    const out = new Array(16).fill(0);
    for (let i = 0; i < 4; ++i) for (let j = 0; j < 4; ++j) for (let k = 0; k < 4; ++k) out[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    return out;
  },
  /** Of a rotation and a translation. */
  inverse(T) {
    const t = [T[3], T[7], T[11]], out = new Array(16).fill(0);
    for (let i = 0; i < 3; ++i) {
      for (let j = 0; j < 3; ++j) out[4 * i + j] = T[4 * j + i];
      out[4 * i + 3] = -(T[i] * t[0] + T[4 + i] * t[1] + T[8 + i] * t[2]);
    }
    out[15] = 1;
    return out;
  },
  transposed(a) { return a.map((_, i) => a[4 * (i % 4) + Math.floor(i / 4)]); },
};

const pointShader = `attribute float x, y, z, reflectivity, ring; attribute vec3 pixel; uniform mat4 T_vehicle_lidar, projection;
uniform float colour, rings, size;
varying float share; varying vec3 shade;
void main() {
  vec3 at = 0.01 * vec3(x, y, z);
  vec4 p = T_vehicle_lidar * vec4(at, 1.0);
  gl_Position = projection * p; gl_PointSize = size;
  shade = pixel;
  share = colour < 0.5 ? 1.0 - 0.9 * clamp(log(length(at) / 2.0) / log(40.0), 0.0, 1.0)
    : 0.1 + 0.9 * clamp(colour < 1.5 ? (p.z + 1.0) / 7.0 : colour < 2.5 ? sqrt(reflectivity) : ring * 255.0 / rings, 0.0, 1.0);
}`;  // as `quantities` of colours.js
const lineShader = `attribute vec3 at; uniform mat4 projection; void main() { gl_Position = projection * vec4(at, 1.0); }`;
const groundShader = `attribute vec2 corner; uniform mat4 projection; varying vec2 at; uniform mat4 T_vehicle_map; uniform vec4 patch;
void main() { at = corner; gl_Position = projection * (T_vehicle_map * vec4(patch.xy + corner * patch.zw, -0.05, 1.0)); }`;
const groundColour = 'precision mediump float; varying vec2 at; uniform sampler2D map; void main() { gl_FragColor = texture2D(map, at); }';
const pointColour = `precision mediump float; varying float share; varying vec3 shade; uniform sampler2D scale; uniform bool shaded;
void main() { gl_FragColor = shaded ? vec4(shade, 1.0) : texture2D(scale, vec2(share, 0.5)); }`;
const lineColour = 'precision mediump float; uniform vec3 tint; void main() { gl_FragColor = vec4(tint, 1.0); }';

const byImage = 4;  // the colour of `Scene.setColour`
const sceneQuantities = [quantities.range, quantities.height, quantities.reflectivity, quantities.ring];
const ringStep = 10, lastRing = 80;  // m
const pickDistance = 10;             // px
const chiSquare99 = 9.21;            // of two degrees of freedom

/** Point of the 99 % ellipse of a covariance (xx, xy, yy) at an angle of its parameter, by Cholesky. */
function ellipsePoint([xx, xy, yy], angle) {
  const a = Math.sqrt(Math.max(xx, 1e-12)), b = xy / a, c = Math.sqrt(Math.max(yy - b * b, 0)), k = Math.sqrt(chiSquare99);
  return [k * a * Math.cos(angle), k * (b * Math.cos(angle) + c * Math.sin(angle))];
}

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl', {antialias: true});
    this.labels = canvas.nextElementSibling;  // a canvas above it
    this.size = 2; this.colour = 1; this.accumulate = 1;
    this.frames = new Map();  // device → the sweep that is shown
    this.past = () => [];     // (device, stamp, count) → that many sweeps up to a time
    this.track = [];          // [x, y, z, stamp] in the odometry frame, stamp in s
    if (!this.gl) {
      canvas.before(element('p', {class: 'empty'}, 'This browser has no WebGL, so the sweep cannot be drawn. Enable it in the browser\'s settings.'));
      return;
    }
    this.points = this.program(pointShader, pointColour);
    this.lines = this.program(lineShader, lineColour);
    this.ground = this.program(groundShader, groundColour);
    this.buffers = {};
    this.grid = this.gridLines();
    this.look('follow');
    this.colours = new ImageColours(() => this.request());
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  program(vertex, fragment) {
    const gl = this.gl, made = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    return made;
  }

  listen() {
    const turn = (dx, dy) => {
      this.yaw -= dx * 0.006;
      this.pitch = Math.min(1.55, Math.max(0.02, this.pitch + dy * 0.006));
      this.draw();
    };
    const zoom = factor => {
      this.distance = Math.min(300, Math.max(4, this.distance * factor));
      this.draw();
    };
    const pan = (dx, dy) => {
      const step = this.distance / this.canvas.clientHeight, [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)];
      const ahead = dy * step / Math.max(0.3, Math.sin(this.pitch)), left = dx * step;
      this.target[0] += c * ahead - s * left;
      this.target[1] += s * ahead + c * left;
      this.draw();
    };
    const held = new Map();  // pointers: one turns, or moves with shift or the right button; two move and zoom
    const apart = () => { const [a, b] = held.values(); return Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1])); };
    this.canvas.addEventListener('contextmenu', e => e.preventDefault());
    this.canvas.addEventListener('dblclick', () => this.look('follow'));
    this.canvas.addEventListener('pointerleave', () => this.point(null));
    this.canvas.addEventListener('pointerdown', e => {
      held.set(e.pointerId, [e.clientX, e.clientY]);
      this.canvas.setPointerCapture(e.pointerId);
    });
    for (const name of ['pointerup', 'pointercancel']) this.canvas.addEventListener(name, e => held.delete(e.pointerId));
    this.canvas.addEventListener('pointermove', e => {
      const last = held.get(e.pointerId);
      if (!last) return this.point([e.offsetX, e.offsetY]);
      const before = held.size === 2 ? apart() : 0;
      held.set(e.pointerId, [e.clientX, e.clientY]);
      const [dx, dy] = [e.clientX - last[0], e.clientY - last[1]];
      if (held.size === 1 && (e.shiftKey || e.buttons === 2)) pan(dx, dy); else if (held.size === 1) turn(dx, dy);
      if (held.size === 2) {
        pan(dx / 2, dy / 2);
        zoom(before / apart());
      }
    });
    this.canvas.addEventListener('wheel', e => {
      e.preventDefault();
      zoom(Math.exp(e.deltaY * 0.001));
    }, {passive: false});
  }

  /** An index of `sceneQuantities`, or `byImage`: the camera's image. */
  setColour(colour) {
    this.colour = colour;
    this.colours?.want(colour === byImage);
    this.draw();
  }

  look(name) {
    this.yaw = 0;
    this.target = [0, 0];  // what is in the middle, m, vehicle's frame
    this.pitch = name === 'top' ? 1.55 : 0.45;
    this.distance = name === 'top' ? 80 : 40;
    this.draw();
  }

  /** Rings of 10 m around the vehicle, and its axes. */
  gridLines() {
    const out = [];
    for (let radius = ringStep; radius <= lastRing; radius += ringStep) {
      for (let k = 0; k < 64; ++k) {
        for (const a of [k, k + 1]) out.push(radius * Math.cos(a * Math.PI / 32), radius * Math.sin(a * Math.PI / 32), 0);
      }
    }
    return new Float32Array(out);
  }

  /** Keeps where the vehicle was. */
  addTrack(frame) {
    const T = frame.header.T_odom_vehicle;
    if (T) {
      const last = this.track[this.track.length - 1];
      if (last && Math.hypot(T[3] - last[0], T[7] - last[1]) > 100) this.track = [];
      this.track.push([T[3], T[7], T[11], Number(frame.header.stamp) / 1e9]);
      if (this.track.length > 5000) this.track.splice(0, 1000);
    }
  }

  /** From the vehicle's frame to the screen. */
  projection() {
    const aspect = this.canvas.width / this.canvas.height, f = 1 / Math.tan(0.5), near = 0.5, far = 600;
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    // Rows: right, up, back, of a camera that looks at the target from behind and above.
    const view = [sy, -cy, 0, 0, cy * sp, sy * sp, cp, 0, -cy * cp, -sy * cp, sp, -this.distance, 0, 0, 0, 1];
    for (let i = 0; i < 3; ++i) view[4 * i + 3] -= view[4 * i] * this.target[0] + view[4 * i + 1] * this.target[1];
    const lens = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), 2 * far * near / (near - far), 0, 0, -1, 0];
    return matrices.multiply(lens, view);
  }

  attribute(program, name, data, size, type, normalised) {
    const gl = this.gl, at = gl.getAttribLocation(program, name);
    const buffer = this.buffers[name] ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STREAM_DRAW);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, type, normalised, 0, 0);
    return at;
  }

  drawLines(projection, data, mode, tint) {
    const gl = this.gl;
    gl.useProgram(this.lines);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.lines, 'projection'), false, matrices.transposed(projection));
    gl.uniform3f(gl.getUniformLocation(this.lines, 'tint'), ...tint);
    const at = this.attribute(this.lines, 'at', data, 3, gl.FLOAT, false);
    gl.drawArrays(mode, 0, data.length / 3);
    gl.disableVertexAttribArray(at);
  }

  /** The street map beneath: its kinds as a texture, made anew when another part of it has come. */
  drawMap(projection, T_vehicle_map) {
    const gl = this.gl, {header, rest} = this.map;
    if (this.drawnMap !== this.map) {
      const pixels = segmentPixels(rest, false);
      this.texture ??= gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, header.columns, header.rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      this.drawnMap = this.map;
    }
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.useProgram(this.ground);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.ground, 'projection'), false, matrices.transposed(projection));
    gl.uniformMatrix4fv(gl.getUniformLocation(this.ground, 'T_vehicle_map'), false, matrices.transposed(T_vehicle_map));
    gl.uniform4f(gl.getUniformLocation(this.ground, 'patch'), header.x, header.y, header.columns * header.cell, header.rows * header.cell);
    const at = this.attribute(this.ground, 'corner', new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]), 2, gl.FLOAT, false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.disableVertexAttribArray(at);
  }

  /** The 99 % ellipse of the position, and where else the vehicle may be. */
  drawPlace(projection, header, T_vehicle_map) {
    const [x0, y0] = [header.T_map_vehicle[3], header.T_map_vehicle[7]];
    const toVehicle = (x, y) => [0, 1].map(i => T_vehicle_map[4 * i] * x + T_vehicle_map[4 * i + 1] * y + T_vehicle_map[4 * i + 3]);
    const outline = [];
    for (let k = 0; k <= 64; ++k) {
      const [dx, dy] = ellipsePoint(header.covariance_map, k * Math.PI / 32);
      outline.push(...toVehicle(x0 + dx, y0 + dy), 0.05);
    }
    this.drawLines(projection, new Float32Array(outline), this.gl.LINE_STRIP, [1, 0.82, 0.3]);
    const crosses = [];
    for (let i = 0; i + 1 < header.particles.length; i += 2) {
      const [x, y] = toVehicle(header.particles[i], header.particles[i + 1]);
      crosses.push(x - 0.4, y, 0.05, x + 0.4, y, 0.05, x, y - 0.4, 0.05, x, y + 0.4, 0.05);
    }
    if (crosses.length) this.drawLines(projection, new Float32Array(crosses), this.gl.LINES, [1, 0.5, 0.3]);
  }

  /** Draws once before the screen is next refreshed: slow drawing does not hold up the messages. */
  request() {
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame(() => {
      this.requested = false;
      this.draw();
    });
  }

  draw() {
    const gl = this.gl;
    if (!gl || this.canvas.clientWidth === 0) return;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    for (const canvas of [this.canvas, this.labels]) fitCanvas(canvas, ratio);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0.07, 0.085, 0.1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const projection = this.drawnProjection = this.projection();
    const place = this.frame?.header;
    const T_vehicle_map = place?.T_map_vehicle ? matrices.inverse(place.T_map_vehicle) : null;
    if (T_vehicle_map && this.map) this.drawMap(projection, T_vehicle_map);
    this.drawLines(projection, this.grid, gl.LINES, [0.26, 0.31, 0.36]);
    this.drawLabels(projection);
    if (!this.frame) return this.drawVehicle(projection);
    const {header} = this.frame;
    if (T_vehicle_map) this.drawPlace(projection, header, T_vehicle_map);
    if (header.T_odom_vehicle && this.track.length > 1) {
      const T_vehicle_odom = matrices.inverse(header.T_odom_vehicle), now = Number(header.stamp) / 1e9;
      const track = this.track.filter(at => at[3] <= now).flatMap(([x, y, z]) => {
        const at = [0, 1, 2].map(i => T_vehicle_odom[4 * i] * x + T_vehicle_odom[4 * i + 1] * y + T_vehicle_odom[4 * i + 2] * z + T_vehicle_odom[4 * i + 3]);
        return [at[0], at[1], at[2] + 0.05];
      });
      this.drawLines(projection, new Float32Array(track), gl.LINE_STRIP, [0.34, 0.71, 0.91]);
    }
    this.drawVehicle(projection);
    const clouds = this.colour === byImage ? this.colours.clouds() : [];
    for (const {header: image, x, y, z, colour, count} of clouds) {
      this.drawPoints(projection, image.T_vehicle_lidar, {x, y, z}, count,
        [this.attribute(this.points, 'pixel', colour, 3, gl.UNSIGNED_BYTE, true)]);
    }
    if (clouds.length === 0) for (const frame of this.frames.values()) this.drawSweeps(projection, frame);
    if (this.pointer) this.showPointer();
  }

  /** A sweep, and those before it at their own poses. */
  drawSweeps(projection, frame) {
    const {header} = frame, gl = this.gl;
    const T_vehicle_odom = header.T_odom_vehicle ? matrices.inverse(header.T_odom_vehicle) : null;
    const past = this.accumulate > 1 && T_vehicle_odom ? this.past(header.device, Number(header.stamp) / 1e9, this.accumulate) : [];
    for (const {header: then, points} of past.length ? past : [frame]) {
      if (then !== header && !then.T_odom_vehicle) continue;
      const T = then === header ? header.T_vehicle_lidar
        : matrices.multiply(matrices.multiply(T_vehicle_odom, then.T_odom_vehicle), then.T_vehicle_lidar);
      this.drawPoints(projection, T, points, then.points,
        ['reflectivity', 'ring'].map(name => this.attribute(this.points, name, points[name], 1, gl.UNSIGNED_BYTE, true)));
    }
  }

  drawVehicle(projection) {
    const car = [[2.2, 0, 0.1], [-2, 0.9, 0.1], [-2, -0.9, 0.1], [2.2, 0, 0.1]];
    this.drawLines(projection, new Float32Array(car.flat()), this.gl.LINE_STRIP, [1, 1, 1]);
  }

  /** Pixel of a point of the vehicle's frame, CSS pixels; null behind the camera. */
  pixel(projection, x, y, z) {
    const [u, v, w] = [0, 1, 3].map(i => projection[4 * i] * x + projection[4 * i + 1] * y + projection[4 * i + 2] * z + projection[4 * i + 3]);
    return w < 0.5 ? null : [(u / w + 1) / 2 * this.canvas.clientWidth, (1 - v / w) / 2 * this.canvas.clientHeight];
  }

  /** Numbers on the rings, ahead and to the sides. */
  drawLabels(projection) {
    const context = this.labels.getContext('2d'), ratio = this.labels.width / this.labels.clientWidth;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.labels.clientWidth, this.labels.clientHeight);
    context.font = '11px system-ui, sans-serif';
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    let last = null;
    for (let radius = ringStep; radius <= lastRing; radius += ringStep) {
      const at = this.pixel(projection, radius, 0, 0);
      if (!at || (last && Math.hypot(at[0] - last[0], at[1] - last[1]) < 16)) continue;
      last = at;
      const text = `${radius} m`, width = context.measureText(text).width + 6;
      context.fillStyle = 'rgba(14, 18, 22, .7)';
      context.fillRect(at[0] - width / 2, at[1] - 7, width, 14);
      context.fillStyle = '#c3ccd4';
      context.fillText(text, ...at);
    }
  }

  /** The pointer is at a pixel, or gone. */
  point(at) {
    this.pointer = at;
    if (at) this.request(); else place('scene-value').textContent = '';
  }

  /** Nearest drawn return to a pixel: {frame, i, at}, at in the vehicle's frame; null: none is near. */
  pick(u, v) {
    let best = null;
    for (const frame of this.frames.values()) {
      const {header, points} = frame, T = header.T_vehicle_lidar;
      const M = matrices.multiply(this.drawnProjection, T), half = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2];
      for (let i = 0; i < header.points; ++i) {
        const x = 0.01 * points.x[i], y = 0.01 * points.y[i], z = 0.01 * points.z[i];
        const w = M[12] * x + M[13] * y + M[14] * z + M[15];
        if (w < 0.5) continue;
        const du = ((M[0] * x + M[1] * y + M[2] * z + M[3]) / w + 1) * half[0] - u;
        const dv = (1 - (M[4] * x + M[5] * y + M[6] * z + M[7]) / w) * half[1] - v;
        const cost = Math.hypot(du, dv) + 0.02 * w;  // of those under the pointer the nearest
        if (Math.abs(du) < pickDistance && Math.abs(dv) < pickDistance && (!best || cost < best.cost)) best = {cost, frame, i, x, y, z};
      }
    }
    if (!best) return null;
    const T = best.frame.header.T_vehicle_lidar, {x, y, z} = best;
    return {...best, at: [0, 1, 2].map(i => T[4 * i] * x + T[4 * i + 1] * y + T[4 * i + 2] * z + T[4 * i + 3])};
  }

  showPointer() {
    const found = this.pick(...this.pointer);
    if (!found) { place('scene-value').textContent = ''; return; }
    const {frame: {header, points}, i, x, y, z, at} = found;
    place('scene-value').textContent = `${header.device}: range ${Math.hypot(x, y, z).toFixed(2)} m, height ${at[2].toFixed(2)} m, ` +
      `reflectivity ${(points.reflectivity[i] / 2.55).toFixed(0)} %, ring ${points.ring[i]}, sweep at ${timeText(Number(header.stamp) / 1e9)}`;
    const mark = this.pixel(this.drawnProjection, ...at), context = this.labels.getContext('2d');
    if (!mark) return;
    context.strokeStyle = '#fff';
    context.lineWidth = 1.5;
    context.beginPath();
    context.arc(...mark, 6, 0, 2 * Math.PI);
    context.stroke();
  }

  /** Draws points of a lidar, cm; `used`: what they are coloured by. */
  drawPoints(projection, T_vehicle_lidar, points, count, used) {
    const gl = this.gl, uniform = name => gl.getUniformLocation(this.points, name), scale = sceneQuantities[this.colour]?.scale;
    gl.useProgram(this.points);
    gl.uniformMatrix4fv(uniform('projection'), false, matrices.transposed(projection));
    gl.uniformMatrix4fv(uniform('T_vehicle_lidar'), false, matrices.transposed(T_vehicle_lidar));
    gl.uniform1f(uniform('colour'), this.colour);
    gl.uniform1f(uniform('size'), this.size * Math.min(2, window.devicePixelRatio || 1));
    gl.uniform1f(uniform('rings'), points.ring ? points.ring.reduce((a, b) => Math.max(a, b), 1) : 1);
    gl.uniform1i(uniform('shaded'), points.ring ? 0 : 1);
    if (scale) gl.bindTexture(gl.TEXTURE_2D, this.scaleTexture(scale));
    const drawn = used.concat(['x', 'y', 'z'].map(axis => this.attribute(this.points, axis, points[axis], 1, gl.SHORT, false)));
    gl.drawArrays(gl.POINTS, 0, count);
    drawn.forEach(at => gl.disableVertexAttribArray(at));
  }

  /** The colours of a scale. */
  scaleTexture(scale) {
    this.textures ??= new Map();
    if (this.textures.has(scale)) return this.textures.get(scale);
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, scaleTable(scale));
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    this.textures.set(scale, texture);
    return texture;
  }
}

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
uniform float colour, rings;
varying vec3 shade;
vec3 ramp(float v) { v = clamp(v, 0.0, 1.0); return clamp(vec3(1.5 - abs(4.0 * v - 3.2), 1.5 - abs(4.0 * v - 2.0), 1.5 - abs(4.0 * v - 0.9)), 0.08, 1.0); }
void main() {
  vec4 p = T_vehicle_lidar * vec4(0.01 * vec3(x, y, z), 1.0);
  gl_Position = projection * p; gl_PointSize = 2.0;
  shade = colour > 2.5 ? pixel : ramp(colour < 0.5 ? 1.1 * sqrt(reflectivity) : colour < 1.5 ? 0.2 + p.z / 6.0 : ring * 255.0 / rings);
}`;
const lineShader = `attribute vec3 at; uniform mat4 projection; void main() { gl_Position = projection * vec4(at, 1.0); }`;
const groundShader = `attribute vec2 corner; uniform mat4 projection; varying vec2 at; uniform mat4 T_vehicle_map; uniform vec4 patch;
void main() { at = corner; gl_Position = projection * (T_vehicle_map * vec4(patch.xy + corner * patch.zw, -0.05, 1.0)); }`;
const groundColour = 'precision mediump float; varying vec2 at; uniform sampler2D map; void main() { gl_FragColor = texture2D(map, at); }';
const pointColour = 'precision mediump float; varying vec3 shade; void main() { gl_FragColor = vec4(shade, 1.0); }';
const lineColour = 'precision mediump float; uniform vec3 tint; void main() { gl_FragColor = vec4(tint, 1.0); }';

/** Colours of the kinds of segments (fusion/streetmap/segment.hpp), in their order; dim, so that the returns stand out. */
const segmentColours = [[18, 22, 26], [52, 56, 62], [104, 108, 114], [62, 60, 52], [70, 56, 40], [104, 98, 40], [26, 46, 30],
  [24, 40, 66], [48, 42, 56], [60, 40, 38], [140, 84, 76], [44, 44, 44], [120, 120, 120]];
const byImage = 3;  // the colour of `Scene.setColour`
const chiSquare99 = 9.21;  // of two degrees of freedom

/** Point of the 99 % ellipse of a covariance (xx, xy, yy) at an angle of its parameter, by Cholesky. */
function ellipsePoint([xx, xy, yy], angle) {
  const a = Math.sqrt(Math.max(xx, 1e-12)), b = xy / a, c = Math.sqrt(Math.max(yy - b * b, 0)), k = Math.sqrt(chiSquare99);
  return [k * a * Math.cos(angle), k * (b * Math.cos(angle) + c * Math.sin(angle))];
}

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl', {antialias: true});
    this.yaw = 0; this.pitch = 0.45; this.distance = 45;
    this.track = [];  // [x, y, z, stamp] in the odometry frame, stamp in s
    if (!this.gl) {
      canvas.before(element('p', {class: 'warn'}, 'This browser has no WebGL: the sweep cannot be drawn.'));
      return;
    }
    this.points = this.program(pointShader, pointColour);
    this.lines = this.program(lineShader, lineColour);
    this.ground = this.program(groundShader, groundColour);
    this.buffers = {};
    this.grid = this.gridLines();
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
    const held = new Map();  // pointers: one turns, two zoom
    const apart = () => { const [a, b] = held.values(); return Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1])); };
    this.canvas.addEventListener('pointerdown', e => {
      held.set(e.pointerId, [e.clientX, e.clientY]);
      this.canvas.setPointerCapture(e.pointerId);
    });
    for (const name of ['pointerup', 'pointercancel']) this.canvas.addEventListener(name, e => held.delete(e.pointerId));
    this.canvas.addEventListener('pointermove', e => {
      const last = held.get(e.pointerId);
      if (!last) return;
      const before = held.size === 2 ? apart() : 0;
      held.set(e.pointerId, [e.clientX, e.clientY]);
      if (held.size === 1) turn(e.clientX - last[0], e.clientY - last[1]);
      if (held.size === 2) zoom(before / apart());
    });
    this.canvas.addEventListener('wheel', e => {
      e.preventDefault();
      zoom(Math.exp(e.deltaY * 0.001));
    }, {passive: false});
  }

  /** 0: reflectivity, 1: height, 2: beam, 3: the camera's image. */
  setColour(colour) {
    this.colour = colour;
    this.colours?.want(colour === byImage);
    this.draw();
  }

  look(name) {
    this.yaw = 0;
    this.pitch = name === 'top' ? 1.55 : 0.45;
    this.distance = name === 'top' ? 80 : 45;
    this.draw();
  }

  /** Rings of 10 m around the vehicle, and its axes. */
  gridLines() {
    const out = [];
    for (let radius = 10; radius <= 80; radius += 10) {
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
    // Rows: right, up, back, of a camera that looks at the vehicle from behind and above.
    const view = [sy, -cy, 0, 0, cy * sp, sy * sp, cp, 0, -cy * cp, -sy * cp, sp, -this.distance, 0, 0, 0, 1];
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
      const pixels = new Uint8Array(4 * header.columns * header.rows);
      for (let i = 0; i < rest.length; ++i) pixels.set([...(segmentColours[rest[i]] ?? [0, 0, 0]), 255], 4 * i);
      this.texture ??= gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, header.columns, header.rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      this.drawnMap = this.map;
    }
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
    this.canvas.width = this.canvas.clientWidth * ratio;
    this.canvas.height = this.canvas.clientHeight * ratio;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0.07, 0.085, 0.1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    const projection = this.projection();
    const place = this.frame?.header;
    const T_vehicle_map = place?.T_map_vehicle ? matrices.inverse(place.T_map_vehicle) : null;
    if (T_vehicle_map && this.map) this.drawMap(projection, T_vehicle_map);
    this.drawLines(projection, this.grid, gl.LINES, [0.22, 0.26, 0.3]);
    const car = [[2.2, 0, 0], [-2, 0.9, 0], [-2, -0.9, 0], [2.2, 0, 0]];
    this.drawLines(projection, new Float32Array(car.flat()), gl.LINE_STRIP, [1, 1, 1]);
    if (!this.frame) return;
    const {header, points} = this.frame;
    if (T_vehicle_map) this.drawPlace(projection, header, T_vehicle_map);
    if (header.T_odom_vehicle && this.track.length > 1) {
      const T_vehicle_odom = matrices.inverse(header.T_odom_vehicle);
      const now = Number(header.stamp) / 1e9;
      const track = this.track.filter(at => at[3] <= now).flatMap(([x, y, z]) => [0, 1, 2].map(i =>
        T_vehicle_odom[4 * i] * x + T_vehicle_odom[4 * i + 1] * y + T_vehicle_odom[4 * i + 2] * z + T_vehicle_odom[4 * i + 3]));
      this.drawLines(projection, new Float32Array(track), gl.LINE_STRIP, [0.45, 0.67, 1]);
    }
    const clouds = this.colour === byImage ? this.colours.clouds() : [];
    for (const {header: image, x, y, z, colour, count} of clouds) {
      this.drawPoints(projection, image.T_vehicle_lidar, {x, y, z}, count,
        [this.attribute(this.points, 'pixel', colour, 3, gl.UNSIGNED_BYTE, true)]);
    }
    if (clouds.length) return;
    this.drawPoints(projection, header.T_vehicle_lidar, points, header.points,
      ['reflectivity', 'ring'].map(name => this.attribute(this.points, name, points[name], 1, gl.UNSIGNED_BYTE, true)));
  }

  /** Draws points of a lidar, cm; `used`: what they are coloured by. */
  drawPoints(projection, T_vehicle_lidar, points, count, used) {
    const gl = this.gl;
    gl.useProgram(this.points);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.points, 'projection'), false, matrices.transposed(projection));
    gl.uniformMatrix4fv(gl.getUniformLocation(this.points, 'T_vehicle_lidar'), false, matrices.transposed(T_vehicle_lidar));
    gl.uniform1f(gl.getUniformLocation(this.points, 'colour'), this.colour ?? 0);
    gl.uniform1f(gl.getUniformLocation(this.points, 'rings'), points.ring ? points.ring.reduce((a, b) => Math.max(a, b), 1) : 1);
    const drawn = used.concat(['x', 'y', 'z'].map(axis => this.attribute(this.points, axis, points[axis], 1, gl.SHORT, false)));
    gl.drawArrays(gl.POINTS, 0, count);
    drawn.forEach(at => gl.disableVertexAttribArray(at));
  }
}

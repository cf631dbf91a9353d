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

const pointShader = `attribute float x, y, z, reflectivity, ring; uniform mat4 T_vehicle_lidar, projection; uniform float colour, rings;
varying vec3 shade;
vec3 ramp(float v) { v = clamp(v, 0.0, 1.0); return clamp(vec3(1.5 - abs(4.0 * v - 3.2), 1.5 - abs(4.0 * v - 2.0), 1.5 - abs(4.0 * v - 0.9)), 0.08, 1.0); }
void main() {
  vec4 p = T_vehicle_lidar * vec4(0.01 * vec3(x, y, z), 1.0);
  gl_Position = projection * p; gl_PointSize = 2.0;
  shade = ramp(colour < 0.5 ? 1.1 * sqrt(reflectivity) : colour < 1.5 ? 0.2 + p.z / 6.0 : ring * 255.0 / rings);
}`;
const lineShader = `attribute vec3 at; uniform mat4 projection; void main() { gl_Position = projection * vec4(at, 1.0); }`;
const pointColour = 'precision mediump float; varying vec3 shade; void main() { gl_FragColor = vec4(shade, 1.0); }';
const lineColour = 'precision mediump float; uniform vec3 tint; void main() { gl_FragColor = vec4(tint, 1.0); }';

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl', {antialias: true});
    this.yaw = 0; this.pitch = 0.45; this.distance = 45;
    this.track = [];  // [x, y, z, stamp] in the odometry frame, stamp in s
    if (!this.gl) return;
    this.points = this.program(pointShader, pointColour);
    this.lines = this.program(lineShader, lineColour);
    this.buffers = {};
    this.grid = this.gridLines();
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
    this.canvas.addEventListener('pointermove', e => { if (e.buttons) turn(e.movementX, e.movementY); });
    this.canvas.addEventListener('pointerdown', e => this.canvas.setPointerCapture(e.pointerId));
    this.canvas.addEventListener('wheel', e => {
      e.preventDefault();
      this.distance = Math.min(300, Math.max(4, this.distance * Math.exp(e.deltaY * 0.001)));
      this.draw();
    }, {passive: false});
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
    this.drawLines(projection, this.grid, gl.LINES, [0.22, 0.26, 0.3]);
    const car = [[2.2, 0, 0], [-2, 0.9, 0], [-2, -0.9, 0], [2.2, 0, 0]];
    this.drawLines(projection, new Float32Array(car.flat()), gl.LINE_STRIP, [1, 1, 1]);
    if (!this.frame) return;
    const {header, points} = this.frame;
    if (header.T_odom_vehicle && this.track.length > 1) {
      const T_vehicle_odom = matrices.inverse(header.T_odom_vehicle);
      const now = Number(header.stamp) / 1e9;
      const track = this.track.filter(at => at[3] <= now).flatMap(([x, y, z]) => [0, 1, 2].map(i =>
        T_vehicle_odom[4 * i] * x + T_vehicle_odom[4 * i + 1] * y + T_vehicle_odom[4 * i + 2] * z + T_vehicle_odom[4 * i + 3]));
      this.drawLines(projection, new Float32Array(track), gl.LINE_STRIP, [0.45, 0.67, 1]);
    }
    gl.useProgram(this.points);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.points, 'projection'), false, matrices.transposed(projection));
    gl.uniformMatrix4fv(gl.getUniformLocation(this.points, 'T_vehicle_lidar'), false, matrices.transposed(header.T_vehicle_lidar));
    gl.uniform1f(gl.getUniformLocation(this.points, 'colour'), this.colour ?? 0);
    gl.uniform1f(gl.getUniformLocation(this.points, 'rings'), points.ring.reduce((a, b) => Math.max(a, b), 1));
    const used = ['x', 'y', 'z'].map(axis => this.attribute(this.points, axis, points[axis], 1, gl.SHORT, false));
    used.push(this.attribute(this.points, 'reflectivity', points.reflectivity, 1, gl.UNSIGNED_BYTE, true),
              this.attribute(this.points, 'ring', points.ring, 1, gl.UNSIGNED_BYTE, true));
    gl.drawArrays(gl.POINTS, 0, header.points);
    used.forEach(at => gl.disableVertexAttribArray(at));
  }
}

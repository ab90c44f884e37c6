// SPDX-License-Identifier: Apache-2.0
import { createInstances, createProgram, InstanceList } from './program';

export const shape = { ellipse: 0, disc: 1, diamond: 2, square: 3, triangle: 4, robot: 5, line: 6, frame: 7 } as const;

// All lengths in CSS pixels, the place from the middle of the window, y up.
export interface Glyph {
  x: number;
  y: number;
  halfX: number;
  halfY: number;
  // Counter-clockwise, rad.
  angle: number;
  shape: number;
  stroke: number;
  // Length of dashes; 0: none.
  dash: number;
  // Packed by rgba().
  line: number;
  fill: number;
}

const vertex = `#version 300 es
layout(location=0) in vec4 i_box;      // x, y, half x, half y
layout(location=1) in vec4 i_look;     // angle, shape, stroke, dash
layout(location=2) in vec4 i_line;
layout(location=3) in vec4 i_fill;
uniform vec2 u_half;                   // half the window, CSS pixels
out vec2 v_p;
flat out vec4 v_box;
flat out vec4 v_look;
flat out vec4 v_line;
flat out vec4 v_fill;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  v_p = corner * (i_box.zw + i_look.z + 2.0);
  float c = cos(i_look.x);
  float s = sin(i_look.x);
  vec2 place = i_box.xy + vec2(c * v_p.x - s * v_p.y, s * v_p.x + c * v_p.y);
  v_box = i_box;
  v_look = i_look;
  v_line = i_line;
  v_fill = i_fill;
  gl_Position = vec4(place / u_half, 0.0, 1.0);
}`;

// Distances to the outline, negative inside (Quilez, "2D distance functions").
const fragment = `#version 300 es
precision highp float;
in vec2 v_p;
flat in vec4 v_box;
flat in vec4 v_look;
flat in vec4 v_line;
flat in vec4 v_fill;
out vec4 o_colour;

float box(vec2 p, vec2 h) {
  vec2 d = abs(p) - h;
  return length(max(d, 0.0)) + min(max(d.x, d.y), 0.0);
}

float ellipse(vec2 p, vec2 h) {
  float k = length(p / h);
  float g = length(p / (h * h));
  return g > 0.0 ? k * (k - 1.0) / g : -min(h.x, h.y);
}

float triangle(vec2 p, float r) {
  const float k = 1.7320508;
  p.x = abs(p.x) - r;
  p.y = p.y + r / k;
  if (p.x + k * p.y > 0.0) p = vec2(p.x - k * p.y, -k * p.x - p.y) / 2.0;
  p.x -= clamp(p.x, -2.0 * r, 0.0);
  return -length(p) * sign(p.y);
}

// An arrow head that points along x, with a notch behind.
float arrow(vec2 p, float r) {
  vec2 v[4] = vec2[4](vec2(1.0, 0.0), vec2(-0.8, 0.78), vec2(-0.4, 0.0), vec2(-0.8, -0.78));
  p /= r;
  float d = dot(p - v[0], p - v[0]);
  float s = 1.0;
  for (int i = 0, j = 3; i < 4; j = i++) {
    vec2 e = v[j] - v[i];
    vec2 w = p - v[i];
    vec2 b = w - e * clamp(dot(w, e) / dot(e, e), 0.0, 1.0);
    d = min(d, dot(b, b));
    bvec3 c = bvec3(p.y >= v[i].y, p.y < v[j].y, e.x * w.y > e.y * w.x);
    if (all(c) || all(not(c))) s = -s;
  }
  return s * sqrt(d) * r;
}

void main() {
  vec2 h = v_box.zw;
  int kind = int(v_look.y);
  float d;
  float along = atan(v_p.y / h.y, v_p.x / h.x) * (h.x + h.y) * 0.5;
  if (kind == 0) d = ellipse(v_p, h);
  else if (kind == 1) d = length(v_p) - h.x;
  else if (kind == 2) d = (abs(v_p.x) + abs(v_p.y) - h.x) * 0.7071;
  else if (kind == 3) d = box(v_p, h * 0.82);
  else if (kind == 4) d = triangle(v_p, h.x * 0.95);
  else if (kind == 5) d = arrow(v_p, h.x);
  else {
    d = box(v_p, h);
    along = v_p.x + (kind == 7 && abs(v_p.y) < h.y - 1.0 ? v_p.y : 0.0);
  }
  float edge = abs(d) - v_look.z * 0.5;
  float line = clamp(0.5 - edge, 0.0, 1.0) * v_line.a;
  if (v_look.w > 0.0 && fract(along / (2.0 * v_look.w)) > 0.5) line = 0.0;
  float fill = clamp(0.5 - d, 0.0, 1.0) * v_fill.a;
  float alpha = line + fill * (1.0 - line);
  if (alpha < 0.004) discard;
  o_colour = vec4(v_line.rgb * line + v_fill.rgb * fill * (1.0 - line), alpha);
}`;

// One draw call for all glyphs, in the order in which they were added.
export class GlyphLayer {
  readonly list: InstanceList;
  private readonly program: WebGLProgram;
  private readonly instances;
  private readonly half;

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.program = createProgram(gl, vertex, fragment);
    this.instances = createInstances(gl, { floats: [4, 4], bytes: 2 });
    this.list = new InstanceList(this.instances.words);
    this.half = gl.getUniformLocation(this.program, 'u_half');
  }

  draw(width: number, height: number): number {
    if (this.list.count === 0) return 0;
    const { gl } = this;
    gl.useProgram(this.program);
    gl.uniform2f(this.half, width / 2, height / 2);
    gl.bindVertexArray(this.instances.array);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.list.upload(gl, this.instances.buffer);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.list.count);
    gl.bindVertexArray(null);
    return 1;
  }
}

export function addGlyph(list: InstanceList, glyph: Glyph) {
  const at = list.add();
  const f = list.floats;
  f[at] = glyph.x;
  f[at + 1] = glyph.y;
  f[at + 2] = glyph.halfX;
  f[at + 3] = glyph.halfY;
  f[at + 4] = glyph.angle;
  f[at + 5] = glyph.shape;
  f[at + 6] = glyph.stroke;
  f[at + 7] = glyph.dash;
  list.colours[at + 8] = glyph.line;
  list.colours[at + 9] = glyph.fill;
}

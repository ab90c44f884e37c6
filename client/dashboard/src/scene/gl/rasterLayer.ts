// SPDX-License-Identifier: Apache-2.0
import type { Affine } from '../affine';
import type { Palette } from '../palette';
import { createInstances, createProgram, InstanceList } from './program';

// A rectangle of a texture layer, drawn as the parallelogram clip(u, v), u and v in [0, 1].
export interface Quad {
  clip: Affine;
  // In texels of the page: [0, size].
  u0: number;
  v0: number;
  u1: number;
  v1: number;
  layer: number;
  style: number;
}

// How a quad is coloured.
export const style = { plain: 0, ghost: 1, selected: 2, before: 3, after: 4 } as const;

const vertex = `#version 300 es
layout(location=0) in vec4 i_axes;
layout(location=1) in vec4 i_place;   // origin, layer, style
layout(location=2) in vec4 i_texels;
out vec2 v_texel;
flat out float v_layer;
flat out int v_style;
flat out vec4 v_limits;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  v_texel = mix(i_texels.xy, i_texels.zw, corner);
  v_limits = i_texels;
  v_layer = i_place.z;
  v_style = int(i_place.w);
  gl_Position = vec4(i_axes.xy * corner.x + i_axes.zw * corner.y + i_place.xy, 0.0, 1.0);
}`;

// Where a pixel is larger than a cell, an obstacle anywhere in it wins: walls never vanish. Obstacles lie above free space
// (by depth), so that no map hides the walls of another one.
const fragment = `#version 300 es
precision highp float;
precision highp sampler2DArray;
uniform sampler2DArray u_cells;
uniform sampler2D u_palette;
uniform vec4 u_background;
uniform vec4 u_selected;
uniform vec4 u_before;
uniform vec4 u_after;
uniform float u_swipe;      // pixels; before is left of it, after is right of it; < 0: off
in vec2 v_texel;
flat in float v_layer;
flat in int v_style;
flat in vec4 v_limits;
out vec4 o_colour;

vec4 at(vec2 texel) {
  vec2 inside = clamp(texel, v_limits.xy + 0.01, v_limits.zw - 0.01);
  float value = texelFetch(u_cells, ivec3(ivec2(inside), int(v_layer)), 0).r;
  return texelFetch(u_palette, ivec2(int(value * 255.0 + 0.5), 0), 0);
}

void main() {
  if (u_swipe >= 0.0 && ((v_style == 3 && gl_FragCoord.x > u_swipe) || (v_style == 4 && gl_FragCoord.x <= u_swipe))) discard;
  vec4 found = at(v_texel);
  vec2 dx = dFdx(v_texel);
  vec2 dy = dFdy(v_texel);
  if (max(dot(dx, dx), dot(dy, dy)) > 1.1) {
    for (int i = 0; i < 9; ++i) {
      vec4 near = at(v_texel + dx * (float(i % 3) - 1.0) / 3.0 + dy * (float(i / 3) - 1.0) / 3.0);
      if (near.a > found.a) found = near;
    }
  }
  if (found.a < 0.25) discard;
  bool occupied = found.a > 0.75;
  vec3 colour = found.rgb;
  float depth = occupied ? 0.2 : 0.5;
  if (v_style == 1) {
    colour = mix(u_background.rgb, colour, occupied ? 0.35 : 0.4);
    depth += 0.4;
  } else if (v_style == 2) {
    colour = mix(colour, u_selected.rgb, occupied ? 0.6 : 0.14);
    depth -= 0.1;
  } else if (u_swipe < 0.0 && v_style >= 3) {
    if (!occupied) discard;
    colour = v_style == 3 ? u_before.rgb : u_after.rgb;
    depth = 0.3;
  }
  gl_FragDepth = depth;
  o_colour = vec4(colour, 1.0);
}`;

// Draws cells of texture arrays: one draw call for each page.
export class RasterLayer {
  private readonly program: WebGLProgram;
  private readonly instances;
  private readonly palette: WebGLTexture;
  private readonly lists = new Map<WebGLTexture, InstanceList>();
  private readonly uniforms;

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.program = createProgram(gl, vertex, fragment);
    this.instances = createInstances(gl, { floats: [4, 4, 4] });
    this.palette = gl.createTexture();
    const uniform = (name: string) => gl.getUniformLocation(this.program, name);
    this.uniforms = {
      cells: uniform('u_cells'), palette: uniform('u_palette'), background: uniform('u_background'), selected: uniform('u_selected'),
      before: uniform('u_before'), after: uniform('u_after'), swipe: uniform('u_swipe'),
    };
  }

  setPalette(palette: Palette) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, palette.cells);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.useProgram(this.program);
    gl.uniform1i(this.uniforms.cells, 0);
    gl.uniform1i(this.uniforms.palette, 1);
    gl.uniform4fv(this.uniforms.background, palette.background);
    gl.uniform4fv(this.uniforms.selected, palette.select);
    gl.uniform4fv(this.uniforms.before, palette.before);
    gl.uniform4fv(this.uniforms.after, palette.after);
  }

  clear() {
    for (const list of this.lists.values()) list.clear();
  }

  add(page: WebGLTexture, { clip, u0, v0, u1, v1, layer, style }: Quad) {
    let list = this.lists.get(page);
    if (!list) this.lists.set(page, (list = new InstanceList(this.instances.words)));
    const at = list.add();
    const f = list.floats;
    f[at] = clip.a;
    f[at + 1] = clip.b;
    f[at + 2] = clip.c;
    f[at + 3] = clip.d;
    f[at + 4] = clip.e;
    f[at + 5] = clip.f;
    f[at + 6] = layer;
    f[at + 7] = style;
    f[at + 8] = u0;
    f[at + 9] = v0;
    f[at + 10] = u1;
    f[at + 11] = v1;
  }

  // Returns the number of draw calls. `blend`: where two quads meet, "darken" or "lighten"; undefined: by depth.
  draw(swipe: number, blend: 'darken' | 'lighten' | undefined): number {
    const { gl } = this;
    let calls = 0;
    gl.useProgram(this.program);
    gl.uniform1f(this.uniforms.swipe, swipe);
    gl.bindVertexArray(this.instances.array);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.palette);
    gl.activeTexture(gl.TEXTURE0);
    if (blend) {
      gl.enable(gl.BLEND);
      gl.blendEquation(blend === 'darken' ? gl.MIN : gl.MAX);
    } else {
      gl.disable(gl.BLEND);
      gl.enable(gl.DEPTH_TEST);
    }
    for (const [page, list] of this.lists) {
      if (list.count === 0) continue;
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, page);
      list.upload(gl, this.instances.buffer);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, list.count);
      ++calls;
    }
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
    return calls;
  }
}

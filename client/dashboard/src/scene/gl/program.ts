// SPDX-License-Identifier: Apache-2.0

function compiled(gl: WebGL2RenderingContext, type: number, source: string): WebGLShader {
  const shader = gl.createShader(type)!;
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
    throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
  }
  return shader;
}

export function createProgram(gl: WebGL2RenderingContext, vertex: string, fragment: string): WebGLProgram {
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl, gl.VERTEX_SHADER, vertex));
  gl.attachShader(program, compiled(gl, gl.FRAGMENT_SHADER, fragment));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`program: ${gl.getProgramInfoLog(program)}`);
  }
  return program;
}

// Floats per instance of one attribute each; `bytes` attributes are four normalised bytes.
export interface Layout {
  floats: number[];
  bytes?: number;
}

// Attributes 0, 1, ... that advance once an instance, in a buffer of `stride` 4-byte words.
export function createInstances(gl: WebGL2RenderingContext, layout: Layout) {
  const words = layout.floats.reduce((sum, n) => sum + n, 0) + (layout.bytes ?? 0);
  const array = gl.createVertexArray();
  const buffer = gl.createBuffer();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  let location = 0;
  let offset = 0;
  for (const n of layout.floats) {
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, n, gl.FLOAT, false, 4 * words, 4 * offset);
    gl.vertexAttribDivisor(location++, 1);
    offset += n;
  }
  for (let i = 0; i < (layout.bytes ?? 0); ++i) {
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, 4, gl.UNSIGNED_BYTE, true, 4 * words, 4 * offset);
    gl.vertexAttribDivisor(location++, 1);
    ++offset;
  }
  gl.bindVertexArray(null);
  return { array, buffer, words };
}

// A list of instances that grows, written each frame and uploaded at once.
export class InstanceList {
  count = 0;
  floats: Float32Array;
  colours: Uint32Array;

  constructor(readonly words: number) {
    this.floats = new Float32Array(words * 256);
    this.colours = new Uint32Array(this.floats.buffer);
  }

  clear() {
    this.count = 0;
  }

  // Where the next instance begins.
  add(): number {
    const at = this.count++ * this.words;
    if (at + this.words > this.floats.length) {
      const next = new Float32Array(2 * this.floats.length);
      next.set(this.floats);
      this.floats = next;
      this.colours = new Uint32Array(next.buffer);
    }
    return at;
  }

  upload(gl: WebGL2RenderingContext, buffer: WebGLBuffer) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.floats.subarray(0, this.count * this.words), gl.STREAM_DRAW);
  }
}

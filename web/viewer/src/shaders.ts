// SPDX-License-Identifier: MIT

/** Points in the frame of their keyframe, whose pose is looked up: when a map moves, three texels per keyframe change. */
export const pointVertex = /* glsl */ `
precision highp float;
precision highp int;
uniform mat4 viewMatrix;
uniform mat4 projectionMatrix;
uniform highp sampler2D poses;   // per keyframe: quaternion; position and wakefulness; map, time, side, shown
uniform sampler2D ramp;
uniform sampler2D mapColours;
uniform int firstKeyframe;
uniform int colourBy;            // 0 height, 1 intensity, 2 map, 3 time, 4 the two sides of a merge
uniform vec2 heightRange;
uniform float heightCut;         // what is higher is not drawn, so that one can look into a building [m]
uniform vec2 timeRange;
uniform float intensityScale;
uniform float spacing;           // between points of the finest level that is drawn [m]
uniform vec2 sizeLimits;         // [px]
uniform float pixelsPerRadian;
uniform float pointScale;
uniform vec3 sleeping;
uniform vec3 movedColour;
uniform vec3 intoColour;
in vec4 place;                   // x, y, z in steps of 4 mm; keyframe
in float intensity;
out vec3 colour;
#ifdef PICK
out vec3 p_world;
#endif

vec4 texel(int keyframe, int which) {
  int at = 3 * keyframe + which;
  return texelFetch(poses, ivec2(at % 1023, at / 1023), 0);
}

void main() {
  int keyframe = firstKeyframe + int(place.w);
  vec4 q = texel(keyframe, 0);
  vec4 t = texel(keyframe, 1);
  vec4 more = texel(keyframe, 2);
  if (more.w < 0.5) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    return;
  }
  vec3 p = place.xyz * 0.004;
  vec3 world = p + 2.0 * cross(q.xyz, cross(q.xyz, p) + q.w * p) + t.xyz;
  if (world.z > heightCut) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    return;
  }
  vec4 view = viewMatrix * vec4(world, 1.0);
  gl_Position = projectionMatrix * view;
  float perspective = projectionMatrix[3][3] < 0.5 ? -view.z : 1.0;
  gl_PointSize = clamp(pointScale * spacing * pixelsPerRadian / max(perspective, 0.01), sizeLimits.x, sizeLimits.y);
#ifdef PICK
  p_world = world;
  gl_PointSize += 2.0;
#else
  float s = 0.0;
  if (colourBy == 0) s = (world.z - heightRange.x) / (heightRange.y - heightRange.x);
  if (colourBy == 1) s = sqrt(intensity * intensityScale);
  if (colourBy == 3) s = (more.y - timeRange.x) / (timeRange.y - timeRange.x);
  float inner = 0.5 / 256.0 + clamp(s, 0.0, 1.0) * 255.0 / 256.0;
  vec3 c = colourBy == 2 ? texelFetch(mapColours, ivec2(int(more.x) % 64, 0), 0).rgb : textureLod(ramp, vec2(inner, 0.5), 0.0).rgb;
  if (colourBy == 2 || colourBy == 4) {
    // Flat colours need some relief.
    float relief = 0.72 + 0.5 * clamp((world.z - heightRange.x) / (heightRange.y - heightRange.x), 0.0, 1.0);
    if (colourBy == 4) c = more.z > 1.5 ? intoColour : more.z > 0.5 ? movedColour : sleeping;
    c *= relief;
  }
  colour = mix(sleeping, c, t.w);
#endif
}`;

export const pointFragment = /* glsl */ `
precision highp float;
#ifdef PICK
in vec3 p_world;
out vec4 result;
void main() { result = vec4(p_world, 1.0); }
#else
in vec3 colour;
out vec4 result;
void main() { result = vec4(colour, 1.0); }
#endif`;

export const screenVertex = /* glsl */ `
out vec2 uv;
void main() {
  uv = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
  gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
}`;

/** Eye-dome lighting (Boucheny 2009): what lies behind its neighbours is darkened, so that edges show without normals. */
export const screenFragment = /* glsl */ `
precision highp float;
uniform sampler2D image;
uniform highp sampler2D depths;
uniform vec2 pixel;
uniform vec2 nearFar;
uniform float strength;
uniform float reach;
uniform int taps;
uniform vec3 low;
uniform vec3 high;
uniform vec3 shade;
in vec2 uv;
out vec4 result;

float logDepth(vec2 at) {
  float d = textureLod(depths, at, 0.0).r;
  if (d >= 1.0) return 0.0;
  float z = nearFar.x * nearFar.y / (nearFar.y - d * (nearFar.y - nearFar.x));
  return log2(z);
}

void main() {
  float raw = textureLod(depths, uv, 0.0).r;
  gl_FragDepth = raw;
  if (raw >= 1.0) {
    result = vec4(mix(low, high, uv.y), 1.0);
    return;
  }
  vec3 c = textureLod(image, uv, 0.0).rgb;
  if (strength > 0.0) {
    float here = logDepth(uv);
    float sum = 0.0;
    for (int i = 0; i < taps; ++i) {
      float angle = 6.2831853072 * (float(i) + 0.5) / float(taps);
      float there = logDepth(uv + reach * pixel * vec2(cos(angle), sin(angle)));
      if (there > 0.0) sum += max(0.0, here - there);
    }
    c = mix(shade, c, exp(-strength * sum / float(taps)));
  }
  result = vec4(c, 1.0);
}`;

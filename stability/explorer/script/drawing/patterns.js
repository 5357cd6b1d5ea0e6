// Hatchings of regions by name: in the shader of a picture, and in a picture without one.

/**
 * Of each its lines or dots as GLSL: the distance of a point p [px] from the next one, half their
 * width [px] and how strongly they cover; and whether they cover a pixel of a coarse picture.
 */
const PATTERNS = {
  "slanted lines": {distance: "abs(mod(p.x - p.y, 7.0) - 3.5) * 0.7071", half: "0.15", strength: "0.62",
    covers: (a, b) => (a + b) % 8 === 0},
  dots: {distance: "length(mod(p + vec2(3.5 * mod(floor(p.y / 6.0), 2.0), 0.0), vec2(7.0, 6.0)) - 3.0)", half: "0.5", strength: "0.55",
    covers: (a, b) => a % 8 === 0 && b % 8 === 0},
  "level lines": {distance: "abs(mod(p.y, 7.0) - 3.5)", half: "0.15", strength: "0.62",
    covers: (a, b) => b % 8 === 0},
  crosses: {distance: "min(abs(mod(p.x - p.y, 9.0) - 4.5), abs(mod(p.x + p.y, 9.0) - 4.5)) * 0.7071", half: "0.15", strength: "0.62",
    covers: (a, b) => (a + b) % 8 === 0 || (a - b) % 8 === 0},
};
const NAMES = Object.keys(PATTERNS);

/** The number of a pattern in the shader; 0 for none. */
export function patternNumber(name) {
  return NAMES.indexOf(name) + 1;
}

/** Whether a pattern covers a pixel. */
export function covers(name, a, b) {
  return name !== "" && PATTERNS[name].covers(a, b);
}

/** GLSL: how strongly a pattern, by its number, covers a point; `pixel` is pixels of the canvas for one of the page. */
export const COVER = `float cover(int pattern, vec2 p) {
${NAMES.map((name, i) => {
    const {distance, half, strength} = PATTERNS[name];
    return `  if (pattern == ${i + 1}) return ${strength} * (1.0 - smoothstep(${half}, ${half} + 1.0 / pixel, ${distance}));`;
  }).join("\n")}
  return 0.0;
}`;

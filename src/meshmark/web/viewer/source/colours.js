// The colour of each corner of the surface under a layer.

import { unpack } from "./decode.js";

const CLAY = [219, 217, 212]; // sRGB of a surface without colours of its own
const LINEAR = Float32Array.from({ length: 256 }, (_, i) => {
  const value = i / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});

/** [r, g, b] in 0 to 255 of "#rrggbb". */
function parse(colour) {
  const number = parseInt(colour.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

/** A function from vertex to [r, g, b] (sRGB, 0 to 255) for a layer that shows one colour a vertex. */
function vertexColour(layer, vertices) {
  if (layer.kind === "surface") {
    if (!layer.values) return () => CLAY;
    const own = unpack(layer.values, 3 * vertices, "colours of the surface");
    return (vertex) => [own[3 * vertex], own[3 * vertex + 1], own[3 * vertex + 2]];
  }
  const values = unpack(layer.values, vertices, `values of the layer ${layer.name}`);
  const scale = layer.legend.colours.map(parse); // from the lowest value to the highest
  const none = layer.legend.missing;
  const grey = none && parse(none.colour);
  const top = layer.values.type === "uint8" ? 254 : 65534; // the largest number itself means "no value"
  const shades = Array.from({ length: top + 1 }, (_, value) => mix(scale, value / top));
  return (vertex) => (values[vertex] > top ? grey || CLAY : shades[values[vertex]]);
}

/** The colour at `share` (0 to 1) of a scale. */
function mix(scale, share) {
  const at = share * (scale.length - 1);
  const low = Math.min(Math.floor(at), scale.length - 2);
  return scale[low].map((value, i) => Math.round(value + (at - low) * (scale[low + 1][i] - value)));
}

/** Linear colours (3 a corner) as Float32Array, in the order of `triangles`. */
export function cornerColours(layer, triangles, vertices) {
  const out = new Float32Array(3 * triangles.length);
  if (layer.corners) {
    unpack(layer.values, out.length, "colours of corners").forEach((value, i) => { out[i] = LINEAR[value]; });
    return out;
  }
  if (layer.kind === "categories") {
    const values = unpack(layer.values, vertices, `values of the layer ${layer.name}`);
    const shades = layer.legend.entries.map((entry) => parse(entry.colour));
    for (let corner = 0; corner < triangles.length; corner += 3) {
      const shade = shades[majority(values, triangles, corner)] || CLAY;
      for (let i = 0; i < 9; i++) out[3 * corner + i] = LINEAR[shade[i % 3]];
    }
    return out;
  }
  const shade = vertexColour(layer, vertices);
  triangles.forEach((vertex, corner) => {
    const colour = shade(vertex);
    for (let i = 0; i < 3; i++) out[3 * corner + i] = LINEAR[colour[i]];
  });
  return out;
}

/** The category that two corners of a triangle share, else that of its first corner: categories do not blend. */
function majority(values, triangles, corner) {
  const [a, b, c] = [values[triangles[corner]], values[triangles[corner + 1]], values[triangles[corner + 2]]];
  return b === c ? b : a;
}
